// Loads a plugin with MeshLab's own plugin manager, as MeshLab's window does, and runs one of its filters on a cloud.
//   plugin_manager_run <plugin.so>       lists its filters and their parameters, separated by tabs:
//     filter name, name in pymeshlab / parameter name, kind, default, label, tooltip, texts of a choice...
//   plugin_manager_run <plugin.so> <filter> <cloud | -> <surface> [cancel] [name=value | name=value%]...
// The cloud and the surface are raw files as tests/hosts/hosts.py writes and reads them. Prints "key value" lines.
#include <common/ml_document/mesh_document.h>
#include <common/plugins/interfaces/filter_plugin.h>
#include <common/plugins/plugin_manager.h>

#include <QApplication>

#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <stdexcept>

namespace
{

std::vector<double> read_doubles(const char* path)
{
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    std::vector<double> values(static_cast<std::size_t>(file.tellg()) / sizeof(double));
    file.seekg(0);
    file.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(values.size() * sizeof(double)));
    if (!file)
        throw std::runtime_error("cannot read the cloud");
    return values;
}

// Header: vertices, colours?, quality?, 16 numbers of the transform by rows. Vertex: x y z r g b a quality selected.
void add_layer(MeshDocument& document, const std::vector<double>& raw)
{
    MeshModel& model = *document.addNewMesh("", "cloud", true);
    const auto n = static_cast<std::size_t>(raw.at(0));
    if (raw.at(1) != 0)
        model.updateDataMask(MeshModel::MM_VERTCOLOR);
    if (raw.at(2) != 0)
        model.updateDataMask(MeshModel::MM_VERTQUALITY);
    for (int i = 0; i < 16; ++i)
        model.cm.Tr.V()[i] = static_cast<Scalarm>(raw.at(3 + i));
    vcg::tri::Allocator<CMeshO>::AddVertices(model.cm, n);
    for (std::size_t i = 0; i < n; ++i)
    {
        const double* v = &raw.at(19 + 9 * i);
        CVertexO& vertex = model.cm.vert[i];
        vertex.P() = Point3m(static_cast<Scalarm>(v[0]), static_cast<Scalarm>(v[1]), static_cast<Scalarm>(v[2]));
        vertex.C() = vcg::Color4b(static_cast<unsigned char>(v[3]), static_cast<unsigned char>(v[4]),
                                  static_cast<unsigned char>(v[5]), static_cast<unsigned char>(v[6]));
        vertex.Q() = static_cast<Scalarm>(v[7]);
        if (v[8] != 0)
            vertex.SetS();
    }
    vcg::tri::UpdateBounding<CMeshO>::Box(model.cm);
}

// Header: vertices, triangles, colours?, quality?, transform. Vertex: x y z r g b a quality. Triangle: corners, faux
// bits.
void write_layer(const MeshModel& model, const char* path)
{
    std::vector<double> raw = {double(model.cm.vert.size()), double(model.cm.face.size()),
                               model.hasDataMask(MeshModel::MM_VERTCOLOR) ? 1.0 : 0.0,
                               model.hasDataMask(MeshModel::MM_VERTQUALITY) ? 1.0 : 0.0};
    for (int i = 0; i < 16; ++i)
        raw.push_back(model.cm.Tr.V()[i]);
    for (const CVertexO& v : model.cm.vert)
        raw.insert(raw.end(), {v.cP()[0], v.cP()[1], v.cP()[2], double(v.cC()[0]), double(v.cC()[1]), double(v.cC()[2]),
                               double(v.cC()[3]), double(v.cQ())});
    for (const CFaceO& f : model.cm.face)
    {
        for (int corner = 0; corner < 3; ++corner)
            raw.push_back(double(vcg::tri::Index(model.cm, f.cV(corner))));
        raw.push_back((f.IsF(0) ? 1 : 0) | (f.IsF(1) ? 2 : 0) | (f.IsF(2) ? 4 : 0));
    }
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(raw.data()), static_cast<std::streamsize>(raw.size() * sizeof(double)));
}

// Changes when anything of the document does that a filter could touch.
std::uint64_t fingerprint(const MeshDocument& document)
{
    std::uint64_t hash = 1469598103934665603u;
    const auto add = [&hash](const void* data, std::size_t size)
    {
        for (std::size_t i = 0; i < size; ++i)
            hash = (hash ^ static_cast<const unsigned char*>(data)[i]) * 1099511628211u;
    };
    const unsigned layers = document.meshNumber();
    const int current = document.mm() ? document.mm()->id() : -1;
    add(&layers, sizeof layers);
    add(&current, sizeof current);
    for (const MeshModel& model : document.meshIterator())
    {
        const int mask = model.dataMask();
        add(&mask, sizeof mask);
        add(model.cm.Tr.V(), 16 * sizeof(Scalarm));
        for (const CVertexO& v : model.cm.vert)
        {
            const int flags = v.cFlags();
            add(&v.cP(), sizeof(Point3m));
            add(&v.cN(), sizeof(Point3m));
            add(&v.cC(), sizeof(vcg::Color4b));
            add(&v.cQ(), sizeof(Scalarm));
            add(&flags, sizeof flags);
        }
    }
    return hash;
}

void set_parameter(RichParameterList& list, const std::string& argument)
{
    const std::size_t equals = argument.find('=');
    const QString name = QString::fromStdString(argument.substr(0, equals));
    QString text = QString::fromStdString(argument.substr(equals + 1));
    RichParameter& parameter = list.getParameterByName(name);
    if (const auto* length = dynamic_cast<const RichPercentage*>(&parameter))
    {
        const bool per_cent = text.endsWith('%');
        text.remove('%');
        const double value = per_cent ? text.toDouble() / 100 * length->max : text.toDouble();
        parameter.setValue(FloatValue(static_cast<Scalarm>(value)));
    }
    else if (const auto* choice = dynamic_cast<const RichEnum*>(&parameter))
        parameter.setValue(IntValue(choice->enumvalues.indexOf(text)));
    else if (parameter.value().isBool())
        parameter.setValue(BoolValue(text == "true"));
    else if (parameter.value().isInt())
        parameter.setValue(IntValue(text.toInt()));
    else if (parameter.value().isFloat())
        parameter.setValue(FloatValue(static_cast<Scalarm>(text.toDouble())));
    else
        parameter.setValue(StringValue(text));
}

std::string describe(const RichParameter& parameter)
{
    QStringList words = {parameter.name(), parameter.stringType(),
                         parameter.value().isString() ? parameter.value().getString() : "",
                         parameter.fieldDescription(), parameter.toolTip()};
    if (parameter.value().isBool())
        words[2] = parameter.value().getBool() ? "on" : "off";
    else if (parameter.value().isInt())
        words[2] = QString::number(parameter.value().getInt());
    else if (parameter.value().isFloat())
        words[2] = QString::number(double(parameter.value().getFloat()));
    if (const auto* choice = dynamic_cast<const RichEnum*>(&parameter))
    {
        words[2] = choice->enumvalues.at(parameter.value().getInt());
        words += choice->enumvalues;
    }
    return words.join('\t').toStdString();
}

bool go_on(const int, const char*)
{
    return true;
}

bool stop(const int, const char*)
{
    return false;
}

int run(int argc, char** argv)
{
    PluginManager manager;
    MeshLabPlugin* loaded = manager.loadPlugin(argv[1]);
    std::cout << "plugin " << loaded->pluginName().toStdString() << "\n";
    if (argc == 2)
    {
        auto* plugin = dynamic_cast<FilterPlugin*>(loaded);
        for (QAction* action : plugin->actions())
        {
            std::cout << "filter " << action->text().toStdString() << "\t"
                      << plugin->pythonFilterName(action).toStdString() << "\n";
            const RichParameterList parameters = plugin->initParameterList(action, MeshDocument());
            for (const RichParameter& parameter : parameters)
                std::cout << "parameter " << describe(parameter) << "\n";
        }
        return 0;
    }
    QAction* action = manager.filterAction(argv[2]);
    if (!action)
        throw std::runtime_error("the plugin has no such filter");
    FilterPlugin* filter = manager.getFilterPluginFromAction(action);
    std::cout << "python_name " << filter->pythonFilterName(action).toStdString() << "\n";

    MeshDocument document;
    filter->setLog(&document.Log);
    if (std::string(argv[3]) != "-")
        add_layer(document, read_doubles(argv[3]));
    RichParameterList parameters = filter->initParameterList(action, document);
    for (const RichParameter& parameter : parameters)
        std::cout << "parameter " << parameter.name().toStdString() << "\n";
    vcg::CallBackPos* callback = go_on;
    for (int i = 5; i < argc; ++i)
        if (std::string(argv[i]) == "cancel")
            callback = stop;
        else
            set_parameter(parameters, argv[i]);

    const std::uint64_t before = fingerprint(document);
    try
    {
        unsigned int post_condition = MeshModel::MM_UNKNOWN;
        const auto values = filter->applyFilter(action, parameters, document, post_condition, callback);
        for (const auto& [name, value] : values)
            std::cout << "value " << name << " " << value.typeName() << " " << value.toString().toStdString() << "\n";
        write_layer(*document.mm(), argv[4]);
        std::cout << "label " << document.mm()->label().toStdString() << "\n";
    }
    catch (const MLException& e)
    {
        std::cout << "error " << e.what() << "\n";
    }
    std::cout << "layers " << document.meshNumber() << "\n";
    std::cout << "unchanged " << (fingerprint(document) == before ? 1 : 0) << "\n";
    for (const auto& line : document.Log.logStringList())
        std::cout << "log " << line.second.toStdString() << "\n";
    return 0;
}

} // namespace

int main(int argc, char** argv)
{
    QApplication application(argc, argv);
    if (argc != 2 && argc < 5)
        return 2;
    try
    {
        return run(argc, argv);
    }
    catch (const std::exception& e)
    {
        std::cout << "escaped " << e.what() << "\n";
        return 1;
    }
}
