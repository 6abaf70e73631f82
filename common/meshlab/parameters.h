#pragma once

#include <recon/errors.h>

#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

/// What lies between the geometry core and MeshLab. These headers know no Qt and no MeshLab: a filter is compiled once
/// and serves every host.
namespace plugin
{

enum class ParameterKind
{
    number, ///< A real number without unit.
    count,  ///< A whole number.
    choice, ///< One of several texts.
    flag,   ///< On or off.
    length, ///< A length in the layer's units; hosts also offer it as per cent of the layer's diagonal.
    text    ///< A string, such as the name of a layer.
};

/// What a host shows of a parameter. `name` is what scripts write: snake_case, never renamed once released.
struct ParameterDeclaration
{
    std::string name;
    std::string label;
    std::string tooltip;
    ParameterKind kind = ParameterKind::number;
    std::variant<double, int, bool, std::string> default_value; ///< number, length / count, choice / flag / text.
    std::vector<std::string> choices;                           ///< Texts of a choice, in the order of its values.
};

/// What the user has chosen, as the host tells it.
class ParameterValues
{
public:
    virtual ~ParameterValues() = default;
    /// Scripts may be older than a parameter.
    virtual bool has(const std::string& name) const = 0;
    virtual double number(const std::string& name) const = 0;
    virtual int count(const std::string& name) const = 0;
    virtual int choice(const std::string& name) const = 0;
    virtual bool flag(const std::string& name) const = 0;
    virtual double length(const std::string& name) const = 0;
    virtual std::string text(const std::string& name) const = 0;
};

/// The decimal number that a user who sees the 32-bit `value` has typed: hosts pass numbers through 32 bits, where 0.7
/// becomes 0.699999988.
double typed_decimal(double value);

/// The parameters of one options struct, each named once. A default is what the struct's own initializer says, so it is
/// written in one place. `member` is a pointer to a data member or a callable that returns a reference to a field
/// (`[](Options& o) -> double& { return o.projection.tolerance; }`). Lengths and numbers may be std::optional<double>:
/// the host shows 0 for "not set". A parameter that a released filter gets later comes first: of scripts that lack a
/// parameter Debian's meshlabserver bears only those.
template <class Options>
class ParameterTable
{
public:
    template <class Member>
    ParameterTable& number(std::string name, Member member, std::string label, std::string tooltip)
    {
        return add_real(ParameterKind::number, std::move(name), member, std::move(label), std::move(tooltip));
    }

    template <class Member>
    ParameterTable& length(std::string name, Member member, std::string label, std::string tooltip)
    {
        return add_real(ParameterKind::length, std::move(name), member, std::move(label), std::move(tooltip));
    }

    template <class Member>
    ParameterTable& count(std::string name, Member member, std::string label, std::string tooltip)
    {
        return add(
            {name, std::move(label), std::move(tooltip), ParameterKind::count, 0, {}},
            [member](ParameterDeclaration& d, Options& o)
            { d.default_value = static_cast<int>(std::invoke(member, o)); },
            [member, name](const ParameterValues& v, Options& o) { std::invoke(member, o) = v.count(name); });
    }

    template <class Member>
    ParameterTable& flag(std::string name, Member member, std::string label, std::string tooltip)
    {
        return add(
            {name, std::move(label), std::move(tooltip), ParameterKind::flag, false, {}},
            [member](ParameterDeclaration& d, Options& o)
            { d.default_value = static_cast<bool>(std::invoke(member, o)); },
            [member, name](const ParameterValues& v, Options& o) { std::invoke(member, o) = v.flag(name); });
    }

    template <class Member>
    ParameterTable& text(std::string name, Member member, std::string label, std::string tooltip)
    {
        return add(
            {name, std::move(label), std::move(tooltip), ParameterKind::text, std::string(), {}},
            [member](ParameterDeclaration& d, Options& o) { d.default_value = std::string(std::invoke(member, o)); },
            [member, name](const ParameterValues& v, Options& o) { std::invoke(member, o) = v.text(name); });
    }

    /// `texts` names the enumerators 0, 1, 2... of the enum in order.
    template <class Member>
    ParameterTable& choice(std::string name, Member member, std::vector<std::string> texts, std::string label,
                           std::string tooltip)
    {
        const int n = static_cast<int>(texts.size());
        return add(
            {name, std::move(label), std::move(tooltip), ParameterKind::choice, 0, std::move(texts)},
            [member](ParameterDeclaration& d, Options& o)
            { d.default_value = static_cast<int>(std::invoke(member, o)); },
            [member, name, n](const ParameterValues& v, Options& o)
            {
                const int i = v.choice(name);
                if (i < 0 || i >= n)
                    throw recon::InvalidInput("The parameter '" + name + "' has no choice number " + std::to_string(i) +
                                              ": choose one of the " + std::to_string(n) + " that the filter lists.");
                auto& field = std::invoke(member, o);
                field = static_cast<std::decay_t<decltype(field)>>(i);
            });
    }

    /// Options to parameter list.
    std::vector<ParameterDeclaration> declare() const
    {
        std::vector<ParameterDeclaration> declarations;
        Options defaults{};
        for (const Entry& entry : entries_)
        {
            declarations.push_back(entry.declaration);
            entry.take_default(declarations.back(), defaults);
        }
        return declarations;
    }

    /// Parameter list to options; what is not in it keeps its default.
    Options read(const ParameterValues& values) const
    {
        Options options{};
        for (const Entry& entry : entries_)
            if (values.has(entry.declaration.name))
                entry.read(values, options);
        return options;
    }

private:
    struct Entry
    {
        ParameterDeclaration declaration;
        std::function<void(ParameterDeclaration&, Options&)> take_default;
        std::function<void(const ParameterValues&, Options&)> read;
    };

    template <class Default, class Read>
    ParameterTable& add(ParameterDeclaration declaration, Default take_default, Read read)
    {
        entries_.push_back({std::move(declaration), std::move(take_default), std::move(read)});
        return *this;
    }

    template <class Member>
    ParameterTable& add_real(ParameterKind kind, std::string name, Member member, std::string label,
                             std::string tooltip)
    {
        return add(
            {name, std::move(label), std::move(tooltip), kind, 0.0, {}},
            [member](ParameterDeclaration& d, Options& o) { d.default_value = shown(std::invoke(member, o)); },
            [member, name, kind](const ParameterValues& v, Options& o)
            {
                const double value = kind == ParameterKind::length ? v.length(name) : typed_decimal(v.number(name));
                set(std::invoke(member, o), value);
            });
    }

    static double shown(double field) { return field; }
    static double shown(const std::optional<double>& field) { return field.value_or(0); }
    static void set(double& field, double value) { field = value; }
    static void set(std::optional<double>& field, double value)
    {
        field = value == 0 ? std::nullopt : std::optional<double>(value);
    }

    std::vector<Entry> entries_;
};

} // namespace plugin
