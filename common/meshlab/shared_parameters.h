#pragma once

/// What several filters say of the same parameter.
namespace plugin::tooltips
{

inline constexpr char threads[] = "Number of threads, 0: one per core. The result does not depend on it.";
inline constexpr char selected_only[] = "Use only the selected vertices.";
inline constexpr char open_holes[] =
    "Leave holes and open ends of the scan open: what lies farther than two local spacings from every point is "
    "dropped, where it reaches three. Off: the surface is closed.";
inline constexpr char keep_components[] =
    "Automatic: stray shells are dropped, that is thin or small bodies and hollows that hold less than a twentieth as "
    "many samples as the one that holds most, unless they are as dense as the rest, seen from the scanner. Largest: "
    "only the component that encloses the largest volume is kept.";

} // namespace plugin::tooltips
