#include <recon/triangulation/power_centre.h>

#include <CGAL/Exact_rational.h>

#include <algorithm>
#include <cmath>

namespace recon
{
namespace
{

/// Offset of the power centre from the first point by Cramer's rule, in numbers of type Number. \returns the
/// determinant of the edges; if it is 0, `offset` is not set.
template <class Number>
Number solve(const std::array<Point, 4>& points, const std::array<double, 4>& weights, Number (&offset)[3])
{
    Number edges[3][3], right[3];
    for (int i = 0; i < 3; ++i)
    {
        right[i] = Number(weights[0]) - Number(weights[i + 1]);
        for (int k = 0; k < 3; ++k)
        {
            edges[i][k] = Number(points[i + 1][k]) - Number(points[0][k]);
            right[i] += edges[i][k] * edges[i][k];
        }
    }
    const auto minor = [&](int i, int j, int a, int b) -> Number
    { return edges[i][a] * edges[j][b] - edges[i][b] * edges[j][a]; };
    const Number determinant =
        edges[0][0] * minor(1, 2, 1, 2) - edges[0][1] * minor(1, 2, 0, 2) + edges[0][2] * minor(1, 2, 0, 1);
    for (int k = 0; k < 3 && determinant != 0; ++k)
    {
        const int a = (k + 1) % 3, b = (k + 2) % 3;
        offset[k] = (right[0] * minor(1, 2, a, b) + right[1] * minor(2, 0, a, b) + right[2] * minor(0, 1, a, b)) /
                    (2 * determinant);
    }
    return determinant;
}

bool has_equal_power(const Point& x, const std::array<Point, 4>& points, const std::array<double, 4>& weights)
{
    const double first = (x - points[0]).squaredNorm() - weights[0];
    const double size = (x - points[0]).squaredNorm() + std::abs(weights[0]);
    double error = 0;
    for (int i = 1; i < 4; ++i)
        error = std::max(error, std::abs((x - points[i]).squaredNorm() - weights[i] - first));
    return error <= 1e-8 * size;
}

} // namespace

Point find_power_centre(const std::array<Point, 4>& points, const std::array<double, 4>& weights)
{
    double size = 1;
    for (int i = 1; i < 4; ++i)
        size *= (points[i] - points[0]).norm();
    double quick[3];
    // Where four points lie on one circle but for their rounding, all of its axis has equal power to them.
    if (std::abs(solve(points, weights, quick)) > 1e-6 * size)
    {
        const Point centre = points[0] + Vector(quick[0], quick[1], quick[2]);
        if (has_equal_power(centre, points, weights))
            return centre;
    }
    _Float128 wide[3] = {}; // its name on every architecture
    if (std::abs(double(solve(points, weights, wide))) > 1e-24 * size)
        return points[0] + Vector(double(wide[0]), double(wide[1]), double(wide[2]));
    CGAL::Exact_rational exact[3] = {0, 0, 0};
    solve(points, weights, exact);
    return points[0] + Vector(CGAL::to_double(exact[0]), CGAL::to_double(exact[1]), CGAL::to_double(exact[2]));
}

} // namespace recon
