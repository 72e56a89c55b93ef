/* One build of the engine, -DBUILD=name -DLANES=n: the table of its functions under that name. cpu_dispatch.c knows all builds. */
#include "lanes.c"
#include "memory.c"
#include "kernels.c"
#include "sparse.c"
#include "sparse_solve.c"
#include "python_callbacks.c"
#include "elements.c"
#include "motion.c"
#include "given.c"
#include "tree_blocks.c"
#include "rigid_tree.c"
#include "tree_motion.c"
#include "state.c"
#include "outputs.c"
#include "model.c"
#include "last_state.c"
#include "start.c"
#include "loop_stages.c"
#include "stepper.c"
#include "adams.c"
#include "runge_kutta.c"
#include "output_block.c"
#include "radau.c"
#ifdef ELEMENTS /* the name of the table of what is needed of elements alone: two builds have it */
#include "derivatives.c"
#include "batches.c"
#include "band.c"
#include "dense.c"
#include "equilibrium.c"
#include "rest_equations.c"
#include "rest_newton.c"
#include "definite.c"
#include "linearized.c"

/* The kinds, then the functions in the order of `ELEMENT_FUNCTIONS` in library.py. */
const void *const ELEMENTS[] = {
    DERIVED,
    spacar_elements_strain, spacar_elements_convective, spacar_elements_inertia, spacar_elements_geometric,
    spacar_elements_rates, spacar_elements_transport, spacar_elements_inertia_gradient, spacar_elements_guard,
    spacar_equilibrium_begin, spacar_equilibrium_end, spacar_equilibrium_newton, spacar_equilibrium_point,
    spacar_equilibrium_factor, spacar_equilibrium_sign, spacar_equilibrium_definite,
    spacar_equilibrium_linearize,
};
#endif

/* The kinds of elements, then the functions in the order of `FUNCTIONS` in library.py. */
const void *const BUILD[] = {
    KINDS,
    spacar_begin, spacar_end, spacar_capsules, spacar_dropped, spacar_renew, spacar_state, spacar_start, spacar_evaluate, spacar_rhs, spacar_stages, spacar_forget, spacar_gradient,
    spacar_determinant, spacar_reduced_mass, spacar_guard, spacar_rcond, spacar_rcond_everywhere,
    spacar_adams_begin, spacar_adams, spacar_adams_value, spacar_runge_kutta, spacar_newton,
    spacar_show, spacar_pass_adams, spacar_pass_runge_kutta, spacar_loop_stages,
};
