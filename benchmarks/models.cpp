#include "models.h"

#include "tests/checks.h"
#include "tests/shapes.h"

#include <Eigen/Geometry>

#include <cmath>
#include <cstring>
#include <ctime>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

namespace benchmarks
{

const std::vector<std::string> grid_a = {
    "bunny_closed", "armadillo_43k",    "igea",      "horse",        "rocker_arm",           "trim_star",
    "block",        "elephant_refined", "fertility", "anchor_dense", "maxplanck_closed_10k", "fandisk_large"};
const std::vector<std::string> grid_b = {"bunny_closed", "armadillo_43k",    "igea",      "horse",
                                         "rocker_arm",   "elephant_refined", "fertility", "maxplanck_closed_10k"};
const std::vector<std::string> grid_c = {"turbine", "casting",      "couplingdown",    "fandisk",
                                         "man",     "bunny_zipper", "mannequin_devil", "laurana50k"};

namespace
{

struct Property
{
    std::string name, type, count_type; // count_type is empty for a scalar
};
struct Element
{
    std::string name;
    std::size_t count = 0;
    std::vector<Property> properties;
};

/// Closes each loop of boundary edges with a fan around its centroid, so that open models too have a genus and a
/// volume.
recon::TriangleMesh close_holes(const recon::TriangleMesh& mesh)
{
    std::map<std::pair<int, int>, int> directed;
    for (const auto& t : mesh.triangles)
        for (int e = 0; e < 3; ++e)
            ++directed[{t[e], t[(e + 1) % 3]}];
    std::map<int, int> parent; // of boundary vertices
    const auto root = [&](int v)
    {
        while (parent[v] != v)
            v = parent[v];
        return v;
    };
    std::vector<std::pair<int, int>> boundary;
    for (const auto& edge : directed)
        if (!directed.count({edge.first.second, edge.first.first}))
        {
            boundary.push_back(edge.first);
            parent.emplace(edge.first.first, edge.first.first);
            parent.emplace(edge.first.second, edge.first.second);
            parent[root(edge.first.first)] = root(edge.first.second);
        }
    recon::TriangleMesh closed = mesh;
    std::map<int, std::pair<recon::Point, int>> sums;
    for (const auto& entry : parent)
    {
        auto& sum = sums.emplace(root(entry.first), std::make_pair(recon::Point::Zero().eval(), 0)).first->second;
        sum.first += mesh.vertices[entry.first];
        ++sum.second;
    }
    std::map<int, int> centre;
    for (const auto& sum : sums)
    {
        centre[sum.first] = int(closed.vertices.size());
        closed.vertices.push_back(sum.second.first / sum.second.second);
    }
    for (const auto& edge : boundary)
        closed.triangles.push_back({edge.second, edge.first, centre[root(edge.first)]});
    return closed;
}

double read_value(std::istream& in, const std::string& type, bool ascii)
{
    if (ascii)
    {
        double value = 0;
        in >> value;
        return value;
    }
    const auto read = [&](auto value) -> double
    {
        in.read(reinterpret_cast<char*>(&value), sizeof value);
        return double(value);
    };
    static const std::map<std::string, int> kinds = {{"char", 0},  {"int8", 0},    {"uchar", 1},  {"uint8", 1},
                                                     {"short", 2}, {"int16", 2},   {"ushort", 3}, {"uint16", 3},
                                                     {"int", 4},   {"int32", 4},   {"uint", 5},   {"uint32", 5},
                                                     {"float", 6}, {"float32", 6}, {"double", 7}, {"float64", 7}};
    switch (kinds.at(type))
    {
    case 0: return read(std::int8_t());
    case 1: return read(std::uint8_t());
    case 2: return read(std::int16_t());
    case 3: return read(std::uint16_t());
    case 4: return read(std::int32_t());
    case 5: return read(std::uint32_t());
    case 6: return read(float());
    default: return read(double());
    }
}

} // namespace

Model load_model(const std::string& path)
{
    std::ifstream in(path, std::ios::binary);
    if (!in)
        throw std::runtime_error("cannot read " + path);
    std::string line;
    bool ascii = false;
    std::vector<Element> elements;
    while (std::getline(in, line) && line.rfind("end_header", 0) != 0)
    {
        std::istringstream words(line);
        std::string word;
        words >> word;
        if (word == "format")
        {
            words >> word;
            ascii = word == "ascii";
            if (word == "binary_big_endian")
                throw std::runtime_error(path + ": big endian PLY is not read");
        }
        else if (word == "element")
        {
            elements.emplace_back();
            words >> elements.back().name >> elements.back().count;
        }
        else if (word == "property")
        {
            Property p;
            words >> p.type;
            if (p.type == "list")
                words >> p.count_type >> p.type;
            words >> p.name;
            elements.back().properties.push_back(p);
        }
    }
    Model model;
    for (const Element& element : elements)
        for (std::size_t i = 0; i < element.count; ++i)
        {
            recon::Point position = recon::Point::Zero(), normal = recon::Point::Zero();
            bool has_normal = false;
            for (const Property& property : element.properties)
            {
                if (!property.count_type.empty())
                {
                    const int n = int(read_value(in, property.count_type, ascii));
                    std::vector<int> corners;
                    for (int k = 0; k < n; ++k)
                        corners.push_back(int(read_value(in, property.type, ascii)));
                    if (element.name == "face")
                        for (int k = 2; k < n; ++k)
                            model.mesh.triangles.push_back({corners[0], corners[k - 1], corners[k]});
                    continue;
                }
                const double value = read_value(in, property.type, ascii);
                const std::string& name = property.name;
                if (name == "x" || name == "y" || name == "z")
                    position[name[0] - 'x'] = value;
                else if (name == "nx" || name == "ny" || name == "nz")
                {
                    normal[name[1] - 'x'] = value;
                    has_normal = true;
                }
            }
            if (element.name == "vertex")
            {
                model.mesh.vertices.push_back(position);
                if (has_normal)
                    model.normals.push_back(normal);
            }
        }
    if (!in)
        throw std::runtime_error(path + " ends early");
    model.diagonal = recon::bounding_box(model.mesh.vertices).diagonal();
    if (!model.mesh.triangles.empty())
    {
        const checks::MeshReport report = checks::examine_mesh(close_holes(model.mesh));
        model.genus = report.genus();
        model.volume = report.volume;
    }
    return model;
}

void save_ply(const std::string& path, const recon::TriangleMesh& mesh)
{
    std::ofstream out(path, std::ios::binary);
    out << "ply\nformat binary_little_endian 1.0\nelement vertex " << mesh.vertices.size()
        << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << mesh.triangles.size()
        << "\nproperty list uchar int vertex_indices\nend_header\n";
    for (const recon::Point& p : mesh.vertices)
    {
        const Eigen::Vector3f f = p.cast<float>();
        out.write(reinterpret_cast<const char*>(f.data()), 12);
    }
    for (const auto& t : mesh.triangles)
    {
        out.put(3);
        out.write(reinterpret_cast<const char*>(t.data()), 12);
    }
}

void save_ply(const std::string& path, const recon::Points& points, const recon::Vectors& normals)
{
    std::ofstream out(path, std::ios::binary);
    out << "ply\nformat binary_little_endian 1.0\nelement vertex " << points.size()
        << "\nproperty float x\nproperty float y\nproperty float z\n";
    if (!normals.empty())
        out << "property float nx\nproperty float ny\nproperty float nz\n";
    out << "end_header\n";
    for (std::size_t i = 0; i < points.size(); ++i)
    {
        const Eigen::Vector3f p = points[i].cast<float>();
        out.write(reinterpret_cast<const char*>(p.data()), 12);
        if (!normals.empty())
        {
            const Eigen::Vector3f n = normals[i].cast<float>();
            out.write(reinterpret_cast<const char*>(n.data()), 12);
        }
    }
}

recon::Vectors vertex_normals(const recon::TriangleMesh& mesh)
{
    recon::Vectors normals(mesh.vertices.size(), recon::Vector::Zero());
    for (const auto& t : mesh.triangles)
        for (int k = 0; k < 3; ++k)
        {
            const recon::Vector a = mesh.vertices[t[(k + 1) % 3]] - mesh.vertices[t[k]],
                                b = mesh.vertices[t[(k + 2) % 3]] - mesh.vertices[t[k]];
            const recon::Vector cross = a.cross(b);
            if (cross.norm() > 0)
                normals[t[k]] += cross.normalized() * std::atan2(cross.norm(), a.dot(b));
        }
    return normals;
}

bool is_right(const checks::MeshReport& report, int genus, double volume)
{
    return report.is_closed_oriented_manifold() && report.components == 1 && report.genus() == genus &&
           std::abs(volume - 1) < 0.03;
}

recon::Points noisy_cloud(const Model& model, double percent, unsigned seed)
{
    if (percent == 0)
        return model.mesh.vertices;
    return shapes::with_noisy_copies(model.mesh.vertices, percent / 100 * model.diagonal, 4, seed);
}

recon::Points with_outliers(recon::Points points, double share, unsigned seed)
{
    shapes::Random random(seed);
    const recon::Box box = recon::bounding_box(points);
    const recon::Vector sides = 1.1 * (box.maximum - box.minimum);
    const std::size_t count = std::size_t(share * double(points.size()));
    for (std::size_t i = 0; i < count; ++i)
    {
        recon::Point p = box.centre();
        for (int k = 0; k < 3; ++k)
            p[k] += (shapes::uniform(random) - 0.5) * sides[k];
        points.push_back(p);
    }
    return points;
}

std::vector<std::string> split_at_commas(const std::string& list)
{
    std::vector<std::string> words;
    std::istringstream in(list);
    for (std::string word; std::getline(in, word, ',');)
        words.push_back(word);
    return words;
}

double cpu_seconds()
{
    timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

} // namespace benchmarks
