/* One build of the engine, -DBUILD=name -DLANES=n: the table of its functions under that name. cpu_dispatch.c knows
   all builds. */
#include "lanes.c"
#include "engine.h"
#include "memory.c"
#include "kernels.c"
#include "sparse.c"
#include "sparse_solve.c"
#include "python_callbacks.c"
#include "elements.c"
#include "motion.c"
#include "tree_blocks.c"
#include "rigid_tree.c"
#include "tree_motion.c"
#include "state.c"
#include "outputs.c"
#include "spec.c"
#include "model.c"
#include "last_state.c"
#include "start.c"
#include "loop_stages.c"
#include "stepper.c"
#include "adams.c"
#include "runge_kutta.c"
#include "output_block.c"
#include "radau.c"
#define SIZE(name) sizeof(name),
static const size_t SIZES[] = { STRUCTURES(SIZE) };
#define ADDRESS(result, name, arguments) spacar_##name,
#ifdef ELEMENTS /* the name of the table of what is needed of elements alone: two builds have it */
#include "derivatives.c"
#include "batches.c"
#include "band.c"
#include "equilibrium.c"
#include "rest_equations.c"
#include "rest_newton.c"
#include "definite.c"

/* The kinds, sizes, functions. */
const void *const ELEMENTS[] = { DERIVED, SIZES, ELEMENT_FUNCTIONS(ADDRESS) };
#endif

const void *const BUILD[] = { KINDS, SIZES, FUNCTIONS(ADDRESS) };
