#include <recon/mesh/kept_components.h>

#include <recon/mesh/crust_mesh.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace recon
{
namespace
{

constexpr double smallest_share_of_triangles = 0.05;
/// Least volume over area [spacings]: of any body, and of one sampled as densely as all, with that many triangles: a
/// board of which both sides were seen. Outliers make bodies of 0.5, nine times sparser; shells in scans have 0.25
/// to 0.4.
constexpr double full = 1.5, thin = 0.4, as_dense = 2;
constexpr std::size_t fewest_triangles = 100;

struct Component
{
    Extent extent;
    std::size_t triangles = 0;
    double solid_angle = 0; ///< Area by the squared distance from where it was seen.

    /// Two triangles a sample, or more where the crust was not simplified.
    double spacing() const { return std::sqrt(2 * extent.area / double(triangles)); }
    /// The same, as seen [radians].
    double angle() const { return std::sqrt(2 * solid_angle / double(triangles)); }
    bool has_thickness(double least) const { return std::abs(extent.volume) >= least * extent.area; }
};

std::vector<Component> list_components(const TriangleMesh& mesh, const MeshComponents& components)
{
    std::vector<Component> list(std::size_t(components.count));
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    {
        Component& component = list[std::size_t(components.of_triangle[i])];
        component.extent.add(mesh, mesh.triangles[i]);
        ++component.triangles;
    }
    return list;
}

/// Tells bodies that are as dense as all, as seen from the scanners, whose readings lie apart as they are far.
class DensityAsSeen
{
public:
    DensityAsSeen(const TriangleMesh& mesh, const MeshComponents& components, double spacing,
                  const std::function<Viewpoints()>& find_viewpoints)
        : mesh_(mesh), components_(components), spacing_(spacing), find_viewpoints_(find_viewpoints)
    {
    }

    bool is_as_dense(std::size_t component, std::vector<Component>& list)
    {
        if (!asked_)
            look(list);
        return angle_of_all_ > 0 && list[component].angle() <= as_dense * angle_of_all_;
    }

private:
    void look(std::vector<Component>& list)
    {
        asked_ = true;
        const Viewpoints viewpoints = find_viewpoints_ ? find_viewpoints_() : Viewpoints();
        if (viewpoints.empty())
            return;
        Component all;
        for (std::size_t i = 0; i < mesh_.triangles.size(); ++i)
        {
            const auto& t = mesh_.triangles[i];
            const Point middle = (mesh_.vertices[t[0]] + mesh_.vertices[t[1]] + mesh_.vertices[t[2]]) / 3;
            Extent extent;
            extent.add(mesh_, t);
            const double squared_range = std::max((middle - viewpoints.of(middle)).squaredNorm(), spacing_ * spacing_);
            list[std::size_t(components_.of_triangle[i])].solid_angle += extent.area / squared_range;
        }
        for (const Component& component : list)
        {
            all.triangles += component.triangles;
            all.solid_angle += component.solid_angle;
        }
        angle_of_all_ = all.angle();
    }

    const TriangleMesh& mesh_;
    const MeshComponents& components_;
    double spacing_; // nothing is seen from nearer
    const std::function<Viewpoints()>& find_viewpoints_;
    bool asked_ = false;
    double angle_of_all_ = 0; ///< [radians], 0: not known.
};

} // namespace

DroppedBodies drop_components(TriangleMesh& mesh, KeepComponents kept, double spacing,
                              const std::function<Viewpoints()>& find_viewpoints)
{
    DroppedBodies dropped;
    const MeshComponents components = find_components(mesh);
    if (kept == KeepComponents::all || components.count < 2)
        return dropped;
    std::vector<Component> list = list_components(mesh, components);
    std::size_t largest = 0, most = 0;
    for (std::size_t k = 0; k < list.size(); ++k)
    {
        if (list[k].extent.volume > list[largest].extent.volume)
            largest = k;
        most = std::max(most, list[k].triangles);
    }
    DensityAsSeen density(mesh, components, spacing, find_viewpoints);
    const auto is_full = [&](std::size_t k)
    {
        const Component& component = list[k];
        const double own = component.spacing(), coarser = std::max(spacing, own);
        if (component.has_thickness(full * coarser))
            return true;
        if (component.extent.volume <= 0 || component.triangles < fewest_triangles ||
            !component.has_thickness(thin * own))
            return false;
        return (own <= as_dense * spacing && component.has_thickness(thin * coarser)) || density.is_as_dense(k, list);
    };
    std::vector<char> is_kept(list.size());
    for (std::size_t k = 0; k < list.size(); ++k)
        is_kept[k] =
            k == largest || (kept == KeepComponents::automatic &&
                             (double(list[k].triangles) >= smallest_share_of_triangles * double(most) || is_full(k)));
    std::vector<char> keep;
    for (const int component : components.of_triangle)
        keep.push_back(is_kept[std::size_t(component)]);
    for (std::size_t k = 0; k < list.size(); ++k)
    {
        const double volume = list[k].extent.volume;
        if (is_kept[k] || volume <= 0) // hollows are no bodies
            continue;
        ++dropped.count;
        dropped.volume += volume / list[largest].extent.volume;
        dropped.samples += double(list[k].triangles) / double(mesh.triangles.size());
    }
    keep_triangles(mesh, keep);
    return dropped;
}

} // namespace recon
