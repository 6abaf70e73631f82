#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace recon
{

/// Tells the caller how far a computation is, and asks whether to go on. Copies share one callback. Call it on the
/// thread that started the computation only: MeshLab runs its event loop inside the callback.
class Progress
{
public:
    /// Called with a fraction of the whole in [0, 1] that never falls and the name of the phase; false cancels.
    using Callback = std::function<bool(double fraction, const std::string& phase)>;

    Progress() = default; ///< Silent, never cancels.
    explicit Progress(Callback callback);

    /// The part of this progress from `begin` to `end` (fractions of it), under the name `phase` or its own.
    Progress part(double begin, double end, const std::string& phase) const;
    Progress part(double begin, double end) const { return part(begin, end, phase_); }

    /// \throws Cancelled if the caller asks to stop.
    void report(double fraction) const;

private:
    struct Shared;
    std::shared_ptr<Shared> shared_;
    std::string phase_;
    double begin_ = 0;
    double end_ = 1;
};

/// Wall-clock seconds per named phase, in the order in which the phases first began.
class PhaseTimes
{
public:
    /// Ends the running phase, if any, and begins `phase`; a name used before goes on adding up.
    void begin(const std::string& phase);
    void end();
    void add(const std::string& phase, double seconds);
    const std::vector<std::pair<std::string, double>>& seconds() const { return seconds_; }

private:
    std::vector<std::pair<std::string, double>> seconds_;
    std::string running_;
    std::chrono::steady_clock::time_point since_;
};

} // namespace recon
