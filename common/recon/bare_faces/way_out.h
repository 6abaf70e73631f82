#pragma once

#include <recon/bare_faces/noisy_faces.h>

namespace recon
{

/// Tells the outside of flat faces by straight lines off them: a solid ends where nothing is met on the way to
/// infinity.
class WayOut
{
public:
    /// \param all faces that may be there. \param sure those of them that most likely are. \param samples of the whole
    /// surface. All outlive this object. \param noise standard deviation > 0 [length].
    WayOut(const NoisyFaces& all, const std::vector<FlatFace>& sure, const Points& samples, double noise)
        : all_(all), sure_(sure), samples_(samples), noise_(noise)
    {
    }

    /// \param beside lines pass samples at this distance [length]. \returns 1 if most lines along the face's normal
    /// meet nothing that may be there, while those against it meet what most likely is; -1 the other way round; 0
    /// otherwise.
    int find(const FlatFace& face, double beside) const;

private:
    struct Share
    {
        double free = 0;    ///< Of all faces and samples [of the area].
        double stopped = 0; ///< By sure faces and samples [of the area].
    };
    Share measure(const FlatFace& face, const Vector& up, double beside) const;
    bool meets(const std::vector<FlatFace>& faces, const Point& from, const Vector& up) const;
    bool meets_samples(const Point& from, const Vector& up, double beside) const;

    const NoisyFaces& all_;
    const std::vector<FlatFace>& sure_;
    const Points& samples_;
    double noise_;
};

} // namespace recon
