// All that is compiled once for each instruction set, in this order. No include guard: see lanes.h.
#include "lanes.h"

#include "ring_kernel.h"

#include "gather_kernel.h"

#include "front_kernel.h"

#include "candidate_kernel.h"

#include "refine_kernel.h"

#include "finish_kernel.h"

#include "box_kernel.h"

#include "entry_kernel.h"
