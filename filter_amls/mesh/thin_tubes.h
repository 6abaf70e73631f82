#pragma once

#include <recon/errors.h>
#include <recon/mesh/mismatch.h>

#include <exception>
#include <optional>
#include <utility>

namespace recon
{

/// Tubes of even points, two or three spacings thick, leave residuals like noise everywhere and are lost where they are
/// denoised. Their points as they are have a surface that violates next to no vote; raw ones of noisy clouds violate
/// 0.025 of the votes and more. \param cleanness, is_doubtful see Cleanness::share(), Cleanness::is_doubtful(): noise
/// leaves hardly half the cells long or neighbours flat. \param violated share of votes, of the denoised labels, 1 if
/// nothing was inside [0..1]. \returns whether the cloud is worth a try as it is.
inline bool may_be_tubes(double cleanness, bool is_doubtful, double violated)
{
    return is_doubtful || (cleanness > 0.65 && violated > suspicious_votes) || (cleanness > 0.6 && violated > 0.05);
}

/// Share of votes that the labels of thin tubes' points as they are violate at most [0..1].
inline constexpr double most_violated_by_tubes = suspicious_votes;

/// \param violated_raw, violated shares of votes, of the labels of the points as they are and of the denoised ones.
inline bool are_tubes(double violated_raw, double violated)
{
    return violated_raw <= most_violated_by_tubes && violated_raw <= 0.25 * violated;
}

/// What `label` makes, or labels of thin tubes. \param label_tubes makes these, if there are any, from what `label`
/// made: an optional, empty where nothing was inside. \throws AlgorithmFailure if nothing was, and no tubes were
/// either.
template <class Label, class LabelTubes>
auto label_unless_tubes(const Label& label, const LabelTubes& label_tubes)
{
    std::optional<decltype(label())> labelled;
    std::exception_ptr failure;
    try
    {
        labelled = label();
    }
    catch (const AlgorithmFailure&)
    {
        failure = std::current_exception();
    }
    if (std::optional<decltype(label())> tubes = label_tubes(std::as_const(labelled)))
        return std::move(*tubes);
    if (failure)
        std::rethrow_exception(failure);
    return std::move(*labelled);
}

} // namespace recon
