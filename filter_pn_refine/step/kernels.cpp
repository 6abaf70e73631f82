#include "kernels.h"

#include "crowded.h"
#include "refine_leaf.h"
#include "workspace.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <type_traits>
#include <vector>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#define PN_INLINE inline __attribute__((always_inline))

namespace recon::pn
{

#define PN_TABLE(name)                                                                                                 \
    const Kernels table = {name,     gather_rows_of_leaf, refine_points_of_leaf, finish_children, meeting_boxes,       \
                           make_fan, find_near_points}

#define PN_INSTRUCTIONS 0
namespace portable
{
#include "filter_pn_refine/loops/inner_loops.h"
PN_TABLE("portable");
} // namespace portable
#undef PN_INSTRUCTIONS

// clang takes target pragmas otherwise.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define PN_HAS_TARGETS
#pragma GCC push_options
#pragma GCC target("arch=x86-64-v3")
#define PN_INSTRUCTIONS 3
namespace v3
{
#include "filter_pn_refine/loops/inner_loops.h"
PN_TABLE("x86-64-v3");
} // namespace v3
#undef PN_INSTRUCTIONS
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("arch=x86-64-v4")
#define PN_INSTRUCTIONS 4
namespace v4
{
#include "filter_pn_refine/loops/inner_loops.h"
PN_TABLE("x86-64-v4");
} // namespace v4
#undef PN_INSTRUCTIONS
#pragma GCC pop_options
#endif

std::vector<const Kernels*> all_kernels()
{
    std::vector<const Kernels*> found = {&portable::table};
#ifdef PN_HAS_TARGETS
    const bool has_v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                        __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
    if (has_v3)
        found.push_back(&v3::table);
    if (has_v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
        found.push_back(&v4::table);
#endif
    return found;
}

const Kernels& kernels()
{
    static const Kernels& best = *all_kernels().back();
    return best;
}

} // namespace recon::pn
