#pragma once

#include <recon/geometry.h>

#include <Eigen/LU>

#include <cmath>
#include <vector>

namespace recon::pn
{

/// Smooth function with value 0 and a given unit gradient at each of a few samples: Hermite radial basis functions
/// (Macedo, Gois, Velho, "Hermite Radial Basis Functions Implicits", 2011) with |x|^3 and a linear part.
class HermiteSurface
{
public:
    /// \param nearest indices of `count` samples at different places. Computes relative to `origin`, in units of
    /// `unit`. \param slack of the gradients, 0 or more: they are met the less the larger it is, for a smoother
    /// function (ridge regression); the values are met anyhow.
    HermiteSurface(const OrientedSamples& samples, const int* nearest, int count, const Point& origin, double unit,
                   double slack = 0)
        : origin_(origin), unit_(unit), count_(count)
    {
        for (int i = 0; i < count; ++i)
            points_[i] = (samples.points[std::size_t(nearest[i])] - origin) / unit;
        const int n = 4 * count + 4;
        System matrix = System::Zero(n, n);
        Solution right = Solution::Zero(n);
        for (int i = 0; i < count; ++i)
        {
            for (int j = 0; j < count; ++j)
            {
                const Vector d = points_[i] - points_[j];
                const double r = d.norm();
                matrix(4 * i, 4 * j) = r * r * r;
                matrix.block<1, 3>(4 * i, 4 * j + 1) = -3 * r * d.transpose();
                matrix.block<3, 1>(4 * i + 1, 4 * j) = 3 * r * d;
                if (r > 0)
                    matrix.block<3, 3>(4 * i + 1, 4 * j + 1) =
                        -3 * (r * Eigen::Matrix3d::Identity() + d * d.transpose() / r);
            }
            matrix.block<3, 3>(4 * i + 1, 4 * i + 1).diagonal().array() += slack;
            const int linear = 4 * count;
            matrix(4 * i, linear) = matrix(linear, 4 * i) = 1;
            matrix.block<1, 3>(4 * i, linear + 1) = points_[i].transpose();
            matrix.block<3, 1>(linear + 1, 4 * i) = points_[i];
            matrix.block<3, 3>(4 * i + 1, linear + 1).setIdentity();
            matrix.block<3, 3>(linear + 1, 4 * i + 1).setIdentity();
            right.segment<3>(4 * i + 1) = samples.normals[std::size_t(nearest[i])];
        }
        weights_ = matrix.partialPivLu().solve(right);
    }

    /// Moves a point onto the surface along the gradient. \returns the gradient there; not finite or zero where there
    /// is none.
    Vector project(Point& p) const
    {
        constexpr double longest = 0.25; // of a step, in units: gradients are weak far from the samples
        Vector x = (p - origin_) / unit_, gradient = Vector::Zero();
        for (int step = 0; step < 6; ++step)
        {
            const double value = evaluate(x, gradient), squared = gradient.squaredNorm();
            if (!(squared > 0))
                break;
            const Vector move = -value / squared * gradient;
            const double length = move.norm();
            x += length > longest ? Vector(move * (longest / length)) : move;
            if (length < 1e-6)
                break;
        }
        evaluate(x, gradient);
        p = origin_ + unit_ * x;
        return gradient;
    }

    static constexpr int most = 16; ///< Samples.

private:
    static constexpr int size = 4 * most + 4;
    using System = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, size, size>;
    using Solution = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, size, 1>;

    double evaluate(const Vector& x, Vector& gradient) const
    {
        const auto linear = 4 * count_;
        gradient = weights_.segment<3>(linear + 1);
        double value = weights_[linear] + gradient.dot(x);
        for (int j = 0; j < count_; ++j)
        {
            const Vector d = x - points_[j];
            const double r = d.norm(), a = weights_[4 * j];
            const Vector b = weights_.segment<3>(4 * j + 1);
            value += a * r * r * r - 3 * r * b.dot(d);
            gradient += 3 * r * a * d - 3 * r * b;
            if (r > 0)
                gradient -= 3 * b.dot(d) / r * d;
        }
        return value;
    }

    Point origin_;
    double unit_;
    int count_;
    Vector points_[most];
    Solution weights_;
};

} // namespace recon::pn
