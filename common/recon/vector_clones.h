#pragma once

// One source for several instruction sets: a function marked RECON_VECTOR_CLONES is compiled for SSE2, AVX2 and AVX-512
// and the machine's best is chosen when the library is loaded (not under ThreadSanitizer, which is not ready by then).
// What takes or returns vector types must be inlined into such a function (RECON_INLINE, RECON_INLINE_LAMBDA); a lambda
// does not inherit its instruction set by itself. A marked function returns nothing: where it returns a double, GCC 12
// leaves out vzeroupper.

#if defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && !defined(__clang__) &&                           \
    !defined(__SANITIZE_THREAD__)
#define RECON_VECTOR_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#pragma GCC diagnostic ignored "-Wpsabi" // no vector type crosses a call
#else
#define RECON_VECTOR_CLONES
#endif
#define RECON_INLINE inline __attribute__((always_inline))
#define RECON_INLINE_LAMBDA __attribute__((always_inline))
