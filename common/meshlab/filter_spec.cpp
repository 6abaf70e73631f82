#include "filter_spec.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <new>

namespace plugin
{

double typed_decimal(double value)
{
    const float single = static_cast<float>(value);
    if (!std::isfinite(single))
        return value;
    char digits[32];
    const std::to_chars_result end = std::to_chars(digits, digits + sizeof digits, single);
    double decimal = value;
    std::from_chars(digits, end.ptr, decimal);
    return decimal;
}

std::string name_without_ending(const InputLayer& layer)
{
    const std::size_t dot = layer.name.rfind('.');
    if (layer.name.empty())
        return "unnamed layer";
    if (dot == std::string::npos || dot == 0)
        return layer.name;
    const std::string ending = layer.name.substr(dot + 1);
    const auto is_letter = [](unsigned char c) { return std::isalpha(c) != 0; };
    const auto is_letter_or_digit = [](unsigned char c) { return std::isalnum(c) != 0; };
    const bool of_a_file = ending.size() <= 4 && std::any_of(ending.begin(), ending.end(), is_letter) &&
                           std::all_of(ending.begin(), ending.end(), is_letter_or_digit);
    return of_a_file ? layer.name.substr(0, dot) : layer.name;
}

std::vector<int> vertices_to_use(const InputLayer& layer, bool selected_only)
{
    const int n = static_cast<int>(layer.points.size());
    if (n == 0)
        throw recon::InvalidInput("The current layer has no vertices: choose a layer with points.");
    std::vector<int> used;
    used.reserve(n);
    for (int i = 0; i < n; ++i)
        if (!selected_only || layer.selected[i])
        {
            recon::check_finite(layer.points[i], i); // here, where the number is still that of the layer
            used.push_back(i);
        }
    if (used.empty())
        throw recon::InvalidInput(
            "No vertex of the current layer is selected: select vertices, or switch 'selected_only' off.");
    return used;
}

recon::OrientedSamples oriented_samples(const InputLayer& layer, const std::vector<int>& vertices)
{
    recon::OrientedSamples samples{pick(layer.points, vertices), pick(layer.normals, vertices)};
    std::size_t missing = 0;
    for (recon::Vector& normal : samples.normals)
    {
        const double length = normal.stableNorm();
        if (length > 0 && std::isfinite(length))
            normal /= length;
        else
            ++missing;
    }
    if (missing > 0)
        throw recon::InvalidInput(std::to_string(missing) + " of " + std::to_string(vertices.size()) +
                                  " vertices have no usable normal: compute normals first, for example with the filter "
                                  "'Compute normals from Delaunay balls'.");
    return samples;
}

std::string message_of_current_exception()
{
    try
    {
        throw;
    }
    catch (const recon::Cancelled&)
    {
        return "The filter was cancelled; nothing was changed.";
    }
    catch (const recon::InvalidInput& e)
    {
        return e.what();
    }
    catch (const recon::AlgorithmFailure& e)
    {
        return e.what();
    }
    catch (const std::bad_alloc&)
    {
        return "There is not enough memory for this many points; nothing was changed. Simplify the cloud or work on a "
               "selection.";
    }
    catch (const std::exception& e)
    {
        return std::string(
                   "An internal error stopped the filter; nothing was changed. Please report it with the data: ") +
               e.what();
    }
    catch (...)
    {
        return "An unknown internal error stopped the filter; nothing was changed. Please report it with the data.";
    }
}

std::string key_of_seconds(const std::string& phase)
{
    std::string key = "seconds_";
    for (char c : phase)
    {
        const bool letter = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
        if (letter)
            key += c;
        else if (c >= 'A' && c <= 'Z')
            key += static_cast<char>(c - 'A' + 'a');
        else
            key += '_';
    }
    return key;
}

void append_seconds(FilterResult& result, const std::vector<std::pair<std::string, double>>& seconds_of_phases)
{
    for (const auto& [phase, seconds] : seconds_of_phases)
        result.values.emplace_back(key_of_seconds(phase), seconds);
}

std::string describe_value(const std::pair<std::string, ResultValue>& value)
{
    char text[64] = "";
    if (const int* i = std::get_if<int>(&value.second))
        std::snprintf(text, sizeof text, "%d", *i);
    else if (const double* d = std::get_if<double>(&value.second))
        std::snprintf(text, sizeof text, "%.6g", *d);
    else
        std::snprintf(text, sizeof text, "%s", std::get<bool>(value.second) ? "yes" : "no");
    return value.first + ": " + text;
}

} // namespace plugin
