#pragma once

#include <recon/bare_faces/complete_flats.h>
#include <recon/labelling/labelled_balls.h>

#include <functional>
#include <optional>

namespace recon
{

/// Completed flat faces stay if this share of the votes violated before is left: under noise 0.23 to 0.58 where they
/// were faces, 0.77 and more where one was not. A face that is none contradicts the samples around it; the benefit of
/// the doubt is with the points as they are.
inline constexpr double clearly_fewer_with_flats = 0.65;

/// Exact samples with those put on flat faces, which come last.
struct LabelledFlats
{
    Points samples;
    LabelledBalls labelled;
    int added = 0; ///< [count]
};

/// Labels of exact samples with their bare flat faces completed; then, if votes are clearly for it, with all walls,
/// too. None if votes are for neither, or if so few are violated without that no face can be missing.
/// \param complete asked only if one can. \param violated share of votes that the labels without these violate.
std::optional<LabelledFlats> label_with_flats(const Points& samples, const std::function<FlatCompletion()>& complete,
                                              double violated, const LabelWithin& label);

} // namespace recon
