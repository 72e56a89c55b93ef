/* One build of the engine, -DBUILD=name -DLANES=n: the table of its functions under that name. levels.c knows all builds. */
#include "lanes.c"
#include "kernels.c"
#include "sparse.c"
#include "elements.c"
#include "motion.c"
#include "state.c"
#include "model.c"
#include "start.c"
#include "march.c"
#include "adams.c"
#include "runge_kutta.c"
#include "radau.c"
#ifdef ELEMENTS /* the name of the table of what is needed of elements alone: two builds have it */
#include "derivatives.c"
#include "batches.c"
#endif

/* The kinds of elements, then the functions in the order of `FUNCTIONS` in library.py. */
const void *const BUILD[] = {
    KINDS,
    spacar_begin, spacar_end, spacar_state, spacar_start, spacar_evaluate, spacar_rhs, spacar_stages, spacar_complete, spacar_gradient,
    spacar_determinant, spacar_reduced_mass, spacar_guard, spacar_rcond,
    spacar_adams_begin, spacar_adams, spacar_adams_value, spacar_runge_kutta, spacar_newton,
};
