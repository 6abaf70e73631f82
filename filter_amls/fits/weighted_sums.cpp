#include "weighted_sums.h"

#include <recon/simd.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace recon
{

using Lanes = simd::FloatLanes;

void Gathered::gather(const Points& points, const std::vector<double>& weights, const std::vector<int>& indices,
                      const Point& origin)
{
    size = int(indices.size());
    const std::size_t padded = std::size_t(simd::padded(size));
    for (auto* values : {&x, &y, &z, &weight})
        values->resize(padded);
    for (int i = 0; i < size; ++i)
    {
        const Eigen::Vector3f p = (points[indices[i]] - origin).cast<float>();
        x[i] = p.x();
        y[i] = p.y();
        z[i] = p.z();
        weight[i] = weights.empty() ? 1 : float(weights[indices[i]]);
    }
    for (std::size_t i = size; i < padded; ++i)
        x[i] = y[i] = z[i] = weight[i] = 0;
}

void Gathered::gather_directions(const Vectors& directions, const std::vector<int>& indices)
{
    const std::size_t padded = std::size_t(simd::padded(size));
    for (auto* values : {&nx, &ny, &nz})
        values->assign(padded, 0);
    for (int i = 0; i < size; ++i)
    {
        const Eigen::Vector3f n = directions[indices[i]].cast<float>();
        nx[i] = n.x();
        ny[i] = n.y();
        nz[i] = n.z();
    }
}

namespace
{

/// What Gathered::gather_facing() asks.
struct Window
{
    const float *x, *y, *z, *weight, *nx, *ny, *nz;
    int n;
    float squared_radius, least_cosine;
    float origin[3], t1[3], t2[3], up[3], facing[3];
};

/// Writes which entries count; `chosen` holds as many as there may be. \returns how many.
RECON_VECTOR_CLONES
int choose_entries(const Window& in, int* chosen)
{
    int count = 0;
    const Lanes nothing = {};
    for (int i = 0; i < in.n; i += simd::lane_count)
    {
        const Lanes x = simd::load(in.x + i) - in.origin[0], y = simd::load(in.y + i) - in.origin[1],
                    z = simd::load(in.z + i) - in.origin[2];
        const Lanes u = x * in.t1[0] + y * in.t1[1] + z * in.t1[2], v = x * in.t2[0] + y * in.t2[1] + z * in.t2[2],
                    height = x * in.up[0] + y * in.up[1] + z * in.up[2];
        const Lanes cosine = simd::load(in.nx + i) * in.facing[0] + simd::load(in.ny + i) * in.facing[1] +
                             simd::load(in.nz + i) * in.facing[2];
        const auto counts = (u * u + v * v + height * height <= in.squared_radius) &
                            (simd::load(in.weight + i) > nothing) & (cosine > in.least_cosine);
        for (int k = 0; k < simd::lane_count; ++k)
        {
            // Written over by the next one if it does not count: no branch to mispredict.
            chosen[count] = i + k;
            count -= counts[k];
        }
    }
    return count;
}

/// Sums of w (1, x, y, z, xx, xy, xz, yy, yz, zz) about the centre.
RECON_VECTOR_CLONES
void sum_moments(const float* px, const float* py, const float* pz, const float* weight, int n, float cx, float cy,
                 float cz, float width, float cut, double* sums)
{
    Lanes total[10] = {};
    const float inverse = 1 / (width * width), limit = cut * cut;
    for (int i = 0; i < n; i += simd::lane_count)
    {
        const Lanes x = simd::load(px + i) - cx, y = simd::load(py + i) - cy, z = simd::load(pz + i) - cz;
        const Lanes e = (x * x + y * y + z * z) * inverse;
        const Lanes w = e <= limit ? simd::load(weight + i) * simd::exp_negative(e) : Lanes{};
        const Lanes wx = w * x, wy = w * y, wz = w * z;
        total[0] += w;
        total[1] += wx;
        total[2] += wy;
        total[3] += wz;
        total[4] += wx * x;
        total[5] += wx * y;
        total[6] += wx * z;
        total[7] += wy * y;
        total[8] += wy * z;
        total[9] += wz * z;
    }
    for (int k = 0; k < 10; ++k)
        sums[k] = simd::sum(total[k]);
}

/// Everything sum_quadric() reads, so that one function serves all kinds of weights.
struct QuadricInput
{
    const float *x, *y, *z, *weight;
    int n;
    float origin[3], normal[3], t1[3], t2[3];
    float width, cut;
    bool robust;
    float about[6], robust_scale;
};

constexpr int quadric_sums = 15 + 6 + 1;

/// Sums of w times the monomials of u and v up to the fourth degree, of w z times those up to the second, and of w^2.
RECON_VECTOR_CLONES
void sum_quadric(const QuadricInput& in, double* sums)
{
    Lanes total[quadric_sums] = {};
    const float inverse = 1 / in.width, limit = in.cut * in.cut, robust = 1 / in.robust_scale;
    for (int i = 0; i < in.n; i += simd::lane_count)
    {
        const Lanes x = simd::load(in.x + i) - in.origin[0], y = simd::load(in.y + i) - in.origin[1],
                    z = simd::load(in.z + i) - in.origin[2];
        const Lanes height = x * in.normal[0] + y * in.normal[1] + z * in.normal[2];
        const Lanes u = (x * in.t1[0] + y * in.t1[1] + z * in.t1[2]) * inverse;
        const Lanes v = (x * in.t2[0] + y * in.t2[1] + z * in.t2[2]) * inverse;
        const Lanes e = u * u + v * v + (height * inverse) * (height * inverse);
        Lanes w = e <= limit ? simd::load(in.weight + i) * simd::exp_negative(e) : Lanes{};
        const Lanes uu = u * u, uv = u * v, vv = v * v;
        if (in.robust)
        {
            const Lanes r = (height - (in.about[0] + in.about[1] * u + in.about[2] * v + in.about[3] * uu +
                                       in.about[4] * uv + in.about[5] * vv)) *
                            robust;
            const Lanes damping = 1.0f / (1.0f + r * r);
            w *= damping * damping;
        }
        const Lanes wu = w * u, wv = w * v, wuu = w * uu, wuv = w * uv, wvv = w * vv, wz = w * height;
        total[0] += w;
        total[1] += wu;
        total[2] += wv;
        total[3] += wuu;
        total[4] += wuv;
        total[5] += wvv;
        total[6] += wuu * u;
        total[7] += wuu * v;
        total[8] += wvv * u;
        total[9] += wvv * v;
        total[10] += wuu * uu;
        total[11] += wuu * uv;
        total[12] += wuu * vv;
        total[13] += wvv * uv;
        total[14] += wvv * vv;
        total[15] += wz;
        total[16] += wz * u;
        total[17] += wz * v;
        total[18] += wz * uu;
        total[19] += wz * uv;
        total[20] += wz * vv;
        total[21] += w * w;
    }
    for (int k = 0; k < quadric_sums; ++k)
        sums[k] = simd::sum(total[k]);
}

} // namespace

void Gathered::gather_facing(const Gathered& all, const Point& origin, const TangentFrame& frame, double radius,
                             const Vector& normal, double least_cosine)
{
    Window window = {};
    window.x = all.x.data();
    window.y = all.y.data();
    window.z = all.z.data();
    window.weight = all.weight.data();
    window.nx = all.nx.data();
    window.ny = all.ny.data();
    window.nz = all.nz.data();
    window.n = all.size;
    window.squared_radius = float(radius * radius);
    window.least_cosine = float(least_cosine);
    for (int k = 0; k < 3; ++k)
    {
        window.origin[k] = float(origin[k]);
        window.t1[k] = float(frame.t1[k]);
        window.t2[k] = float(frame.t2[k]);
        window.up[k] = float(frame.normal[k]);
        window.facing[k] = float(normal[k]);
    }
    chosen_.resize(std::size_t(simd::padded(all.size)) + 1);
    size = choose_entries(window, chosen_.data());
    const std::size_t padded = std::size_t(simd::padded(size));
    for (auto* values : {&x, &y, &z, &weight})
        values->resize(padded);
    for (int i = 0; i < size; ++i)
    {
        const std::size_t from = std::size_t(chosen_[std::size_t(i)]);
        x[i] = all.x[from];
        y[i] = all.y[from];
        z[i] = all.z[from];
        weight[i] = all.weight[from];
    }
    for (std::size_t i = size; i < padded; ++i)
        x[i] = y[i] = z[i] = weight[i] = 0;
}

WeightedPlane fit_plane(const Gathered& points, const Point& centre, double width, double cut)
{
    double s[10];
    sum_moments(points.x.data(), points.y.data(), points.z.data(), points.weight.data(), points.size, float(centre.x()),
                float(centre.y()), float(centre.z()), float(width), float(cut), s);
    WeightedPlane plane;
    plane.mass = s[0];
    if (!(s[0] > 0))
    {
        plane.mean = centre;
        return plane;
    }
    const Vector mean = Vector(s[1], s[2], s[3]) / s[0];
    Eigen::Matrix3d covariance;
    covariance << s[4], s[5], s[6], s[5], s[7], s[8], s[6], s[8], s[9];
    covariance /= s[0];
    covariance -= mean * mean.transpose();
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    solver.computeDirect(covariance / (width * width));
    plane.mean = centre + mean;
    plane.normal = solver.eigenvectors().col(0);
    plane.spread = solver.eigenvalues()[1] * width * width;
    if (!plane.normal.allFinite())
        plane.normal = Vector::UnitZ();
    return plane;
}

TangentFrame::TangentFrame(const Vector& unit_normal) : normal(unit_normal)
{
    // Duff et al. 2017: no branch but the sign.
    const double sign = std::copysign(1.0, normal.z()), a = -1 / (sign + normal.z()), b = normal.x() * normal.y() * a;
    t1 = Vector(1 + sign * normal.x() * normal.x() * a, sign * b, -sign * normal.x());
    t2 = Vector(b, sign + normal.y() * normal.y() * a, -normal.y());
}

Vector normal_of(const QuadricFit& fit, const TangentFrame& frame, double width)
{
    return (frame.normal - fit.c[1] / width * frame.t1 - fit.c[2] / width * frame.t2).normalized();
}

QuadricFit fit_quadric(const Gathered& points, const Point& origin, const TangentFrame& frame,
                       const QuadricWeights& how)
{
    QuadricInput in;
    in.x = points.x.data();
    in.y = points.y.data();
    in.z = points.z.data();
    in.weight = points.weight.data();
    in.n = points.size;
    for (int k = 0; k < 3; ++k)
    {
        in.origin[k] = float(origin[k]);
        in.normal[k] = float(frame.normal[k]);
        in.t1[k] = float(frame.t1[k]);
        in.t2[k] = float(frame.t2[k]);
    }
    in.width = float(how.width);
    in.cut = float(how.cut);
    in.robust = how.robust_about != nullptr;
    in.robust_scale = float(how.robust_scale);
    for (int k = 0; k < 6; ++k)
        in.about[k] = in.robust ? float(how.robust_about->c[k]) : 0;
    double s[quadric_sums];
    sum_quadric(in, s);

    QuadricFit fit;
    fit.mass = s[0];
    if (!(s[0] > 0))
        return fit;
    fit.effective = s[0] * s[0] / s[21];
    Eigen::Matrix<double, 6, 6> m;
    m << s[0], s[1], s[2], s[3], s[4], s[5],   //
        s[1], s[3], s[4], s[6], s[7], s[8],    //
        s[2], s[4], s[5], s[7], s[8], s[9],    //
        s[3], s[6], s[7], s[10], s[11], s[12], //
        s[4], s[7], s[8], s[11], s[12], s[13], //
        s[5], s[8], s[9], s[12], s[13], s[14];
    for (int k = 1; k < 3; ++k)
        m(k, k) += how.ridge_linear * s[0];
    for (int k = 3; k < 6; ++k)
        m(k, k) += how.ridge_quadratic * s[0];
    const SmallCholesky<6> cholesky(m);
    if (!cholesky.valid())
        return fit;
    Eigen::Matrix<double, 6, 1> right;
    right << s[15], s[16], s[17], s[18], s[19], s[20];
    const Eigen::Matrix<double, 6, 1> c = cholesky.solve(right);
    for (int k = 0; k < 6; ++k)
        fit.c[k] = c[k];
    fit.valid = c.allFinite();
    return fit;
}

} // namespace recon
