#include <recon/minimum_cut.h>

#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <boost/range/iterator_range.hpp>

#include <algorithm>
#include <cstddef>
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

    // Both directions of each edge next to each other, then sorted by their tail as compressed rows want.
    struct Arc
    {
        int tail, head;
        double capacity;
        std::size_t pair; ///< which arc of the unsorted list is the reverse
    };
    std::vector<Arc> arcs;
    arcs.reserve(2 * (graph.edges.size() + std::size_t(graph.nodes)));
    const auto add = [&](int a, int b, double forward, double backward)
    {
        const std::size_t i = arcs.size();
        arcs.push_back({a, b, forward, i + 1});
        arcs.push_back({b, a, backward, i});
    };
    for (const SignedEdge& e : graph.edges)
        add(e.a, e.b, e.weight, e.weight);
    for (int i = 0; i < graph.nodes; ++i)
    {
        // Only the difference matters: what both sides ask for is cut in any case.
        const double difference = to_outer[i] - to_inner[i];
        if (difference > 0)
            add(source, i, difference, 0);
        else if (difference < 0)
            add(i, sink, -difference, 0);
    }
    std::vector<std::size_t> order(arcs.size());
    std::vector<std::size_t> first(std::size_t(graph.nodes) + 3, 0);
    for (const Arc& arc : arcs)
        ++first[arc.tail + 1];
    for (std::size_t i = 0; i + 1 < first.size(); ++i)
        first[i + 1] += first[i];
    std::vector<std::size_t> position(arcs.size());
    for (std::size_t i = 0; i < arcs.size(); ++i)
    {
        position[i] = first[arcs[i].tail]++;
        order[position[i]] = i;
    }

    using Graph = boost::compressed_sparse_row_graph<boost::directedS>;
    using Edge = boost::graph_traits<Graph>::edge_descriptor;
    std::vector<std::pair<int, int>> pairs;
    std::vector<double> capacity, residual;
    pairs.reserve(arcs.size());
    capacity.reserve(arcs.size());
    for (const std::size_t i : order)
    {
        pairs.emplace_back(arcs[i].tail, arcs[i].head);
        capacity.push_back(arcs[i].capacity);
    }
    residual = capacity;
    const Graph flow(boost::edges_are_sorted, pairs.begin(), pairs.end(), std::size_t(graph.nodes) + 2);
    std::vector<Edge> edges;
    edges.reserve(arcs.size());
    for (const Edge& e : boost::make_iterator_range(boost::edges(flow)))
        edges.push_back(e);
    std::vector<Edge> reverse;
    reverse.reserve(arcs.size());
    for (const std::size_t i : order)
        reverse.push_back(edges[position[arcs[i].pair]]);
    const std::size_t nodes = std::size_t(graph.nodes) + 2;
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
