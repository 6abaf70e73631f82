#include <recon/progress.h>

#include <recon/errors.h>

#include <algorithm>

namespace recon
{

struct Progress::Shared
{
    Callback callback;
    double highest = 0;
};

Progress::Progress(Callback callback)
{
    if (callback)
    {
        shared_ = std::make_shared<Shared>();
        shared_->callback = std::move(callback);
    }
}

Progress Progress::part(double begin, double end, const std::string& phase) const
{
    Progress result = *this;
    result.begin_ = begin_ + begin * (end_ - begin_);
    result.end_ = begin_ + end * (end_ - begin_);
    result.phase_ = phase;
    return result;
}

void Progress::report(double fraction) const
{
    if (!shared_)
        return;
    const double whole = begin_ + std::clamp(fraction, 0.0, 1.0) * (end_ - begin_);
    shared_->highest = std::max(shared_->highest, whole);
    if (!shared_->callback(shared_->highest, phase_))
        throw Cancelled();
}

void PhaseTimes::begin(const std::string& phase)
{
    end();
    running_ = phase;
    add(phase, 0);
    since_ = std::chrono::steady_clock::now();
}

void PhaseTimes::end()
{
    if (running_.empty())
        return;
    add(running_, std::chrono::duration<double>(std::chrono::steady_clock::now() - since_).count());
    running_.clear();
}

void PhaseTimes::add(const std::string& phase, double seconds)
{
    const auto found =
        std::find_if(seconds_.begin(), seconds_.end(), [&](const auto& entry) { return entry.first == phase; });
    if (found != seconds_.end())
        found->second += seconds;
    else
        seconds_.emplace_back(phase, seconds);
}

} // namespace recon
