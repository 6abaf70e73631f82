#include <recon/labelling/minimum_cut.h>

#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <boost/graph/compressed_sparse_row_graph.hpp>

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>

namespace recon
{

std::vector<Side> label_by_minimum_cut(const SignedGraph& graph, const std::vector<TerminalTie>& ties)
{
    const int source = graph.nodes, sink = graph.nodes + 1; // outer, inner
    std::vector<double> to_outer(std::size_t(graph.nodes), 0), to_inner(std::size_t(graph.nodes), 0);
    for (const TerminalTie& tie : ties)
        (tie.side == Side::outer ? to_outer : to_inner)[tie.node] += tie.weight;
    double everything = 1;
    for (const TerminalTie& tie : ties)
        everything += tie.weight;
    for (int i = 0; i < graph.nodes; ++i)
        if (graph.is_root[i])
            to_outer[i] = 2 * everything;

    // Only the difference matters: what both sides ask for is cut in any case.
    const auto for_all_edges = [&](auto&& call)
    {
        for (const SignedEdge& e : graph.edges)
            call(e.a, e.b, e.weight, e.weight);
        for (int i = 0; i < graph.nodes; ++i)
            if (to_outer[i] > to_inner[i])
                call(source, i, to_outer[i] - to_inner[i], 0);
            else if (to_outer[i] < to_inner[i])
                call(i, sink, to_inner[i] - to_outer[i], 0);
    };
    // Compressed rows, as the graph wants them: arcs sorted by their tail.
    using Graph = boost::compressed_sparse_row_graph<boost::directedS, boost::no_property, boost::no_property,
                                                     boost::no_property, std::uint32_t, std::uint32_t>;
    using Edge = boost::graph_traits<Graph>::edge_descriptor;
    const std::size_t nodes = std::size_t(graph.nodes) + 2;
    std::vector<std::uint32_t> next(nodes + 1, 0);
    for_all_edges(
        [&](int a, int b, double, double)
        {
            ++next[a + 1];
            ++next[b + 1];
        });
    std::partial_sum(next.begin(), next.end(), next.begin());
    std::vector<std::pair<std::uint32_t, std::uint32_t>> arcs(next.back());
    std::vector<double> capacity(arcs.size());
    std::vector<Edge> reverse(arcs.size());
    for_all_edges(
        [&](int a, int b, double forward, double backward)
        {
            const std::uint32_t there = next[a]++, back = next[b]++;
            arcs[there] = {a, b};
            arcs[back] = {b, a};
            capacity[there] = forward;
            capacity[back] = backward;
            reverse[there] = Edge(std::uint32_t(b), back);
            reverse[back] = Edge(std::uint32_t(a), there);
        });
    const Graph flow(boost::edges_are_sorted, arcs.begin(), arcs.end(), std::uint32_t(nodes));
    std::vector<std::pair<std::uint32_t, std::uint32_t>>().swap(arcs); // the graph has its own by now
    std::vector<double> residual = capacity;
    std::vector<boost::default_color_type> colour(nodes);
    std::vector<Edge> predecessor(nodes);
    std::vector<long> distance(nodes);
    const auto edge_index = boost::get(boost::edge_index, flow);
    const auto vertex_index = boost::get(boost::vertex_index, flow);
    boost::boykov_kolmogorov_max_flow(flow, boost::make_iterator_property_map(capacity.begin(), edge_index),
                                      boost::make_iterator_property_map(residual.begin(), edge_index),
                                      boost::make_iterator_property_map(reverse.begin(), edge_index),
                                      boost::make_iterator_property_map(predecessor.begin(), vertex_index),
                                      boost::make_iterator_property_map(colour.begin(), vertex_index),
                                      boost::make_iterator_property_map(distance.begin(), vertex_index), vertex_index,
                                      boost::graph_traits<Graph>::vertex_descriptor(source),
                                      boost::graph_traits<Graph>::vertex_descriptor(sink));
    std::vector<Side> labels(std::size_t(graph.nodes), Side::inner);
    for (int i = 0; i < graph.nodes; ++i)
        if (colour[i] == boost::black_color)
            labels[i] = Side::outer;
    return labels;
}

} // namespace recon
