#include "shapes.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

/// Shapes of flat faces.
namespace shapes
{
namespace
{

using recon::Point;
using recon::Points;
using recon::Vector;

/// Parallelograms with one sample a unit of area, jittered.
struct Faces
{
    Points points;
    Random random{3};

    void add(const Point& corner, const Vector& u, const Vector& v)
    {
        const int columns = std::max(int(u.norm()), 1), rows = std::max(int(v.norm()), 1);
        for (int i = 0; i < columns; ++i)
            for (int j = 0; j < rows; ++j)
            {
                const double along = (i + 0.2 + 0.6 * uniform(random)) / columns;
                points.push_back(corner + along * u + (j + 0.2 + 0.6 * uniform(random)) / rows * v);
            }
    }
};

} // namespace

Cup::Cup(double wall, double side) : wall_(wall), side_(side)
{
    const double height = 0.75 * side, inside = side - 2 * wall, depth = height - wall;
    volume = side * side * height - inside * inside * depth;
    Faces faces;
    faces.add({0, 0, 0}, {side, 0, 0}, {0, side, 0});
    faces.add({wall, wall, wall}, {inside, 0, 0}, {0, inside, 0});
    for (const double far : {0.0, 1.0})
    {
        faces.add({0, far * side, 0}, {side, 0, 0}, {0, 0, height});
        faces.add({far * side, 0, 0}, {0, side, 0}, {0, 0, height});
        faces.add({wall, wall + far * inside, wall}, {inside, 0, 0}, {0, 0, depth});
        faces.add({wall + far * inside, wall, wall}, {0, inside, 0}, {0, 0, depth});
        faces.add({0, far * (side - wall), height}, {side, 0, 0}, {0, wall, 0});
        faces.add({far * (side - wall), wall, height}, {wall, 0, 0}, {0, inside, 0});
    }
    points = std::move(faces.points);
}

Points Cup::seen_above(double height) const
{
    const double low = wall_ - 1e-6, high = side_ - low;
    Points seen;
    for (const Point& p : points)
        if (p.z() > height || p.head<3>().minCoeff() < low || p.head<2>().maxCoeff() > high)
            seen.push_back(p);
    return seen;
}

Points scan_boxes(const std::vector<recon::Box>& boxes, int views, int pixels)
{
    constexpr double golden_angle = 2.399963, far = 1e9;
    recon::Box all;
    for (const recon::Box& box : boxes)
    {
        all.minimum = all.minimum.cwiseMin(box.minimum);
        all.maximum = all.maximum.cwiseMax(box.maximum);
    }
    const double radius = all.diagonal() / 2;
    Points hits;
    for (int view = 0; view < views; ++view)
    {
        const double z = 1 - (2 * view + 1.0) / views, angle = view * golden_angle, flat = std::sqrt(1 - z * z);
        const Vector ray = -Vector(flat * std::cos(angle), flat * std::sin(angle), z), right = ray.unitOrthogonal();
        const auto at = [&](int pixel) { return radius * ((2 * pixel + 1.0) / pixels - 1); };
        for (int i = 0; i < pixels; ++i)
            for (int j = 0; j < pixels; ++j)
            {
                const Point origin = all.centre() - 2 * radius * ray + at(i) * right + at(j) * ray.cross(right);
                double first = far;
                for (const recon::Box& box : boxes)
                {
                    const Vector a = (box.minimum - origin).cwiseQuotient(ray),
                                 b = (box.maximum - origin).cwiseQuotient(ray);
                    const double enters = a.cwiseMin(b).maxCoeff();
                    if (enters < a.cwiseMax(b).minCoeff())
                        first = std::min(first, enters);
                }
                if (first < far)
                    hits.push_back(origin + first * ray);
            }
    }
    return hits;
}

HeatSink::HeatSink(int fins, double wall, double gap, double height, double length, double base, std::uint64_t seed)
{
    const double pitch = wall + gap, width = fins * wall + (fins - 1) * gap, top = base + height;
    volume = width * length * base + fins * wall * length * height;
    Faces faces{{}, Random(seed)};
    faces.add({0, 0, 0}, {width, 0, 0}, {0, length, 0});
    for (const double far : {0.0, 1.0})
    {
        faces.add({far * width, 0, 0}, {0, length, 0}, {0, 0, base});
        faces.add({0, far * length, 0}, {width, 0, 0}, {0, 0, base});
    }
    for (int fin = 0; fin < fins; ++fin)
    {
        const double left = fin * pitch;
        faces.add({left, 0, top}, {wall, 0, 0}, {0, length, 0});
        if (fin + 1 < fins)
            faces.add({left + wall, 0, base}, {gap, 0, 0}, {0, length, 0});
        for (const double far : {0.0, 1.0})
        {
            faces.add({left + far * wall, 0, base}, {0, length, 0}, {0, 0, height});
            faces.add({left, far * length, base}, {wall, 0, 0}, {0, 0, height});
        }
    }
    points = std::move(faces.points);
}

} // namespace shapes
