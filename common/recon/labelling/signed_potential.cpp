#include <recon/labelling/signed_potential.h>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>

#include <cmath>
#include <utility>

namespace recon
{

std::vector<double> find_potential(const SignedGraph& graph, ParityForest& forest, int root)
{
    const int n = graph.nodes;
    std::vector<int> unknown(std::size_t(n), -1);
    int unknowns = 0, ignored = 0;
    const int root_cluster = root < 0 ? -1 : forest.find(root, ignored);
    for (int i = 0; i < n; ++i)
        if (forest.find(i, ignored) == i && i != root_cluster)
            unknown[i] = unknowns++;
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns), diagonal = Eigen::VectorXd::Constant(unknowns, 1e-6);
    for (const SignedEdge& e : graph.edges)
    {
        const int a = forest.find(e.a, ignored), b = forest.find(e.b, ignored);
        if (a == b)
            continue;
        for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)})
        {
            if (from == root_cluster)
                continue;
            diagonal[unknown[from]] += std::abs(e.weight);
            if (to == root_cluster)
                right[unknown[from]] += e.weight;
            else
                entries.emplace_back(unknown[from], unknown[to], -e.weight);
        }
    }
    for (int i = 0; i < unknowns; ++i)
        entries.emplace_back(i, i, diagonal[i]);
    Eigen::SparseMatrix<double, Eigen::RowMajor> laplacian(unknowns, unknowns);
    laplacian.setFromTriplets(entries.begin(), entries.end());
    Eigen::ConjugateGradient<Eigen::SparseMatrix<double, Eigen::RowMajor>, Eigen::Lower | Eigen::Upper> solver;
    solver.setTolerance(1e-4);
    solver.setMaxIterations(1000);
    solver.compute(laplacian);
    const Eigen::VectorXd potential = solver.solve(right);
    std::vector<double> result(std::size_t(n), 1);
    for (int i = 0; i < n; ++i)
    {
        const int cluster = forest.find(i, ignored);
        if (cluster != root_cluster)
            result[i] = potential[unknown[cluster]];
    }
    return result;
}

} // namespace recon
