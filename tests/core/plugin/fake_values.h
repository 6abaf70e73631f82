#pragma once

#include <meshlab/parameters.h>

#include <map>

/// A host whose user has left every parameter at its default, but for those in `changed`. As hosts do, it passes
/// numbers through 32 bits.
class FakeValues : public plugin::ParameterValues
{
public:
    using Value = std::variant<double, int, bool, std::string>;

    explicit FakeValues(const std::vector<plugin::ParameterDeclaration>& declarations,
                        const std::map<std::string, Value>& changed = {})
    {
        for (const auto& d : declarations)
            values_[d.name] = d.default_value;
        for (const auto& [name, value] : changed)
            values_.at(name) = value;
    }

    /// As a script that is older than the parameter.
    void forget(const std::string& name) { values_.erase(name); }

    bool has(const std::string& name) const override { return values_.count(name) > 0; }
    double number(const std::string& name) const override
    {
        return static_cast<float>(std::get<double>(values_.at(name)));
    }
    int count(const std::string& name) const override { return std::get<int>(values_.at(name)); }
    int choice(const std::string& name) const override { return std::get<int>(values_.at(name)); }
    bool flag(const std::string& name) const override { return std::get<bool>(values_.at(name)); }
    double length(const std::string& name) const override { return std::get<double>(values_.at(name)); }
    std::string text(const std::string& name) const override { return std::get<std::string>(values_.at(name)); }

private:
    std::map<std::string, Value> values_;
};
