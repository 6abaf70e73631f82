#include <recon/labelling/signed_labelling.h>

#include <recon/labelling/contraction.h>
#include <recon/labelling/parity_forest.h>
#include <recon/labelling/signed_potential.h>
#include <recon/labelling/single_moves.h>
#include <recon/parallel.h>

#include <cmath>
#include <optional>
#include <utility>

namespace recon
{
namespace
{

/// Joins the roots, and the pairs that are merged whatever the edges say. `root` becomes one of the roots, -1 if there
/// is none.
ParityForest join_certain(const SignedGraph& graph, int& root)
{
    ParityForest forest(graph.nodes);
    root = -1;
    for (int i = 0; i < graph.nodes; ++i)
        if (graph.is_root[i])
        {
            root = root < 0 ? i : root;
            forest.join(root, i);
        }
    for (const auto& pair : graph.merged)
        forest.join(pair[0], pair[1]);
    return forest;
}

std::vector<Side> threshold(const std::vector<double>& potential)
{
    std::vector<Side> labels;
    for (const double p : potential)
        labels.push_back(p > 0 ? Side::outer : Side::inner);
    return labels;
}

/// Joins the nodes on which the potential leaves no doubt, those of either side.
void join_clear(const std::vector<double>& potential, ParityForest& forest, int root)
{
    constexpr double clear = 0.5; // nearer to a side than to the middle
    int inner = -1;
    for (int i = 0; i < int(potential.size()); ++i)
    {
        if (!(std::abs(potential[i]) > clear))
            continue;
        int& side = potential[i] > 0 ? root : inner;
        side = side < 0 ? i : side;
        forest.join(side, i);
    }
}

} // namespace

std::vector<Side> label_by_contraction(const SignedGraph& graph)
{
    int root = -1;
    ParityForest forest = join_certain(graph, root);
    std::vector<Side> labels = contract(graph, std::move(forest), root);
    SingleMoves(graph).improve(labels);
    return labels;
}

std::vector<Side> label_by_potential(const SignedGraph& graph)
{
    int root = -1;
    ParityForest forest = join_certain(graph, root);
    std::vector<Side> labels = threshold(find_potential(graph, forest, root));
    SingleMoves(graph).improve(labels);
    return labels;
}

std::vector<Side> label_by_best(const SignedGraph& graph, int threads)
{
    int root = -1;
    ParityForest forest = join_certain(graph, root);
    std::optional<SingleMoves> moves;
    std::vector<double> potential;
    parallel_invoke(
        threads, [&] { potential = find_potential(graph, forest, root); }, [&] { moves.emplace(graph, 1); });
    std::vector<Side> labels = threshold(potential), others;
    double energy = 0, energy_of_others = 0;
    parallel_invoke(
        threads,
        [&]
        {
            join_clear(potential, forest, root);
            others = contract(graph, std::move(forest), root);
            moves->improve(others);
            energy_of_others = measure_energy(graph, others);
        },
        [&]
        {
            moves->improve(labels);
            energy = measure_energy(graph, labels);
        });
    return energy < energy_of_others ? labels : others;
}

} // namespace recon
