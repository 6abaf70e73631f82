#include <recon/noise/sheet_stack.h>

#include <recon/noise/patch_fit.h>
#include <recon/simd.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <utility>

namespace recon
{
namespace
{

constexpr double pi = 3.14159265358979323846;
constexpr int nearest_tried = 7;
constexpr int most_planes = nearest_tried * (nearest_tried - 1) / 2;
constexpr double least_sine = 0.5; // between the two neighbours that span a plane
/// Neighbourhoods that hold three to five sheets tell best: their radii are two to three gaps.
constexpr int fewest = 48;
constexpr double growth = 1.6;
/// Half the thickness of the slab that a sheet fills [radii of the neighbourhood].
constexpr double half_slab = 0.15;
/// Share of the sheet's points that may lie in the gaps beside it, each half as thick as the slab; of a plane's.
constexpr double largest_in_gap = 0.15, hopeless_in_gap = 0.5;
/// Share of them that must lie beyond the gap.
constexpr double least_beyond = 0.5;
/// Seen along the normal, points of other sheets lie this near to a sheet's own by chance [spacings of all together].
constexpr double by_chance = 0.5;
/// Share of the pairs to be expected of sheets. The steps of a depth camera or a range image have none: each of its
/// pixels has one depth.
constexpr double least_pairs = 0.25;
/// Standard deviation across its length below which a sheet is a line [radii]; half a disc has 0.26.
constexpr double row_width = 0.2;

using simd::FloatLanes;

/// Neighbours around the centre [radii], also coordinate by coordinate for vectors; what fills these up is far away.
struct Neighbourhood
{
    std::vector<Vector> places;
    float coordinates[3][simd::padded(most_around_stack)];

    void fill(const Points& points, const Point& centre, const int* neighbours, int count, double radius)
    {
        places.clear();
        for (int i = 0; i < count; ++i)
            places.push_back((points[neighbours[i]] - centre) / radius);
        for (int axis = 0; axis < 3; ++axis)
            for (int i = 0; i < simd::padded(count); ++i)
                coordinates[axis][i] = i < count ? float(places[i][axis]) : 1e6f;
    }
};

struct Fullest
{
    int plane = 0;
    double inside = -1, in_gap = 0; ///< Places in its slab and in the gaps beside that.
};

/// Of the planes through the centre the one in whose slab most of `count` places lie.
RECON_VECTOR_CLONES void find_fullest(const Neighbourhood& around, const float (*normals)[3], int planes, int count,
                                      Fullest& fullest)
{
    for (int k = 0; k < planes; ++k)
    {
        FloatLanes inside{}, in_gap{};
        for (int i = 0; i < count; i += simd::lane_count)
        {
            const FloatLanes height = normals[k][0] * simd::load(around.coordinates[0] + i) +
                                      normals[k][1] * simd::load(around.coordinates[1] + i) +
                                      normals[k][2] * simd::load(around.coordinates[2] + i);
            constexpr float limit = float(half_slab * half_slab);
            const FloatLanes one = FloatLanes{} + 1, squared = height * height;
            inside += squared < limit ? one : FloatLanes{};
            in_gap += squared < 4 * limit ? one : FloatLanes{};
        }
        const double sum = simd::sum(inside);
        if (sum > fullest.inside)
            fullest = {k, sum, simd::sum(in_gap) - sum};
    }
}

/// Normal of the fullest of the planes through the centre and two of its nearest. Zero if no two span one, or so much
/// lies in its gaps that no quadric mends it.
Vector find_plane(const Neighbourhood& around)
{
    float normals[most_planes][3];
    int planes = 0;
    const int tried = std::min(nearest_tried + 1, int(around.places.size()));
    for (int i = 1; i < tried; ++i)
        for (int j = 1; j < i; ++j)
        {
            const Vector cross = around.places[i].cross(around.places[j]);
            const double size = cross.norm();
            if (size <= least_sine * around.places[i].norm() * around.places[j].norm())
                continue;
            for (int axis = 0; axis < 3; ++axis)
                normals[planes][axis] = float(cross[axis] / size);
            ++planes;
        }
    if (planes == 0)
        return Vector::Zero();
    Fullest fullest;
    find_fullest(around, normals, planes, int(around.places.size()), fullest);
    if (fullest.in_gap > hopeless_in_gap * fullest.inside)
        return Vector::Zero();
    const float* normal = normals[fullest.plane];
    return Vector(normal[0], normal[1], normal[2]).normalized();
}

/// Standard deviation of the Gaussian of which the slab shows that much [radii].
double correct_for_slab(double seen)
{
    double sigma = seen;
    for (int i = 0; i < 8; ++i)
    {
        const double a = half_slab / std::max(sigma, 1e-12);
        const double lost = a * std::sqrt(2 / pi) * std::exp(-0.5 * a * a) / std::erf(a * std::sqrt(0.5));
        sigma = std::min(seen / std::sqrt(std::max(1 - lost, 0.2)), half_slab);
    }
    return sigma;
}

/// Places in the plane of the sheet [radii].
std::vector<Eigen::Vector2d> list_across(const Neighbourhood& around, const Eigen::Matrix3d& frame)
{
    std::vector<Eigen::Vector2d> result;
    for (const Vector& place : around.places)
        result.push_back((frame * place).tail<2>());
    return result;
}

/// Whether the members are hardly more than a line: a row of a scan, which lies in one plane with the scanner, whatever
/// the noise along its rays.
bool are_row(const std::vector<Eigen::Vector2d>& across, const std::vector<int>& members)
{
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
    for (const int i : members)
    {
        mean += across[std::size_t(i)];
        squares += across[std::size_t(i)] * across[std::size_t(i)].transpose();
    }
    mean /= double(members.size());
    const Eigen::Matrix2d spread = squares / double(members.size()) - mean * mean.transpose();
    const double half = spread.trace() / 2, least = half - std::sqrt(std::max(half * half - spread.determinant(), 0.0));
    return least < row_width * row_width;
}

/// Whether the others fill the gaps between the members, as seen along the normal: steps of one surface rather than
/// sheets. \param members ascending.
bool fill_gaps(const std::vector<Eigen::Vector2d>& across, const std::vector<int>& members)
{
    const double all = double(across.size()), near = by_chance * by_chance * pi / all;
    std::size_t next = 0;
    int pairs = 0;
    for (int i = 0; i < int(across.size()); ++i)
    {
        if (next < members.size() && members[next] == i)
        {
            ++next;
            continue;
        }
        for (const int k : members)
            pairs += (across[std::size_t(k)] - across[std::size_t(i)]).squaredNorm() < near;
    }
    const double inside = double(members.size());
    return pairs < least_pairs * near * inside * (all - inside);
}

/// The slab around the plane, bent to a quadric. Nothing if what lies beside it is no gap, or nothing lies beyond.
std::optional<StackedSheet> fit_sheet(const Neighbourhood& around, const Vector& normal, double radius)
{
    constexpr int rounds = 3;
    const int n = int(around.places.size());
    Eigen::Matrix3d frame;
    frame.row(0) = normal;
    frame.row(1) = normal.unitOrthogonal();
    frame.row(2) = normal.cross(frame.row(1).transpose());
    PatchRow quadric = PatchRow::Zero();
    std::vector<int> members;
    int in_gap = 0;
    double squares = 0;
    for (int round = 0; round < rounds; ++round)
    {
        Eigen::Matrix<double, patch_coefficients, patch_coefficients> matrix;
        matrix.setZero();
        PatchRow right = PatchRow::Zero();
        members.clear();
        in_gap = 0;
        squares = 0;
        for (int i = 0; i < n; ++i)
        {
            const Vector u = frame * around.places[i];
            const PatchRow row = patch_row(u);
            const double height = u[0] - row.dot(quadric);
            if (std::abs(height) < half_slab)
            {
                matrix += row * row.transpose();
                right += row * u[0];
                squares += height * height;
                members.push_back(i);
            }
            else if (std::abs(height) < 2 * half_slab)
                ++in_gap;
        }
        if (round + 1 == rounds)
            break;
        matrix.diagonal().array() += 1e-9 * double(members.size());
        quadric = matrix.ldlt().solve(right);
    }
    const int inside = int(members.size());
    if (inside < 2 * patch_coefficients || in_gap > largest_in_gap * inside ||
        n - inside - in_gap < least_beyond * inside)
        return {};
    const std::vector<Eigen::Vector2d> across = list_across(around, frame);
    if (are_row(across, members) || fill_gaps(across, members))
        return {};
    return StackedSheet{radius * correct_for_slab(std::sqrt(squares / (inside - patch_coefficients))),
                        inside / (pi * radius * radius), std::move(members)};
}

} // namespace

std::optional<StackedSheet> find_stacked_sheet(const Points& points, const Point& centre, const int* neighbours,
                                               const double* squared, int count)
{
    Neighbourhood around;
    for (double wanted = fewest; wanted <= std::min(most_around_stack, count); wanted *= growth)
    {
        const int n = int(wanted);
        const double radius = std::sqrt(squared[n - 1]);
        if (!(radius > 0))
            continue;
        around.fill(points, centre, neighbours, n, radius);
        const Vector normal = find_plane(around);
        if (normal.isZero())
            continue;
        if (std::optional<StackedSheet> sheet = fit_sheet(around, normal, radius))
            return sheet;
    }
    return {};
}

} // namespace recon
