#include <recon/bare_faces/rim_curves.h>

#include <recon/bare_faces/planar_faces.h>
#include <recon/disjoint_sets.h>

#include <map>
#include <utility>

namespace recon
{

std::vector<RimCurve> list_rim_curves(const FlatFace& face)
{
    std::map<int, int> place;
    for (const int v : face.rim)
        place.insert({v, int(place.size())});
    const std::vector<std::array<int, 2>> border = list_border_edges(face.triangles);
    DisjointSets sets(face.rim.size());
    for (const auto& [a, b] : border)
        sets.join(place.at(a), place.at(b));
    std::map<int, RimCurve> curves;
    std::vector<int> place_on_curve;
    for (int k = 0; k < int(face.rim.size()); ++k)
    {
        RimCurve& curve = curves[int(sets.find(k))];
        place_on_curve.push_back(int(curve.places.size()));
        curve.places.push_back(k);
    }
    for (const auto& [v, w] : border)
    {
        const int a = place.at(v), b = place.at(w);
        curves[int(sets.find(a))].edges.push_back({place_on_curve[a], place_on_curve[b]});
    }
    std::vector<RimCurve> result;
    for (auto& entry : curves)
        if (!entry.second.edges.empty())
            result.push_back(std::move(entry.second));
    return result;
}

} // namespace recon
