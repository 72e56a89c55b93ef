/* What the engine and Python share: structures of numbers and addresses, functions. interface.py reads this text. */
typedef struct Model Model;
enum { MAX_ORDER = 12, ORDERS = 13 };

/* A call that failed: NOT_ANSWERED where Python could not answer, and keeps the error. */
enum {
    OK = 0, NO_CONVERGENCE = -1, SINGULAR = -2, NOT_FINITE = -3, JUMP = -4, NO_MEMORY = -5, NOT_ANSWERED = -6,
    MUCH_WORK = -7
};
/* Of an evaluation: the path there has to be followed; the reduced mass matrix of the start is in doubt. */
enum { FAR_AWAY = 1, DOUBTFUL_MASS = 2 };
/* What Python is asked. */
enum { ASK_MOTION = 0, ASK_STRESS = 1, ASK_STRAIN = 2, ASK_CONVECTIVE = 3, ASK_INERTIA = 4, ASK_OUTPUT = 5 };
/* Why steps end; which accepted steps are inspected (spacar/dynamics/loaded_mechanism.py). */
enum { ARRIVED = 0, AT_OUTPUT = 1, PAUSED = 2, TOO_SMALL = 3, NOT_EVALUATED = 4, INTERRUPTED = 5 };
enum { LOOK_NEVER = 0, LOOK_AT_DETERMINANTS = 1, LOOK_AT_VELOCITIES = 2, LOOK_ALWAYS = 3 };
/* The iteration of a Radau step. */
enum { ITERATED = 0, NOT_CONVERGED = 1, NO_RATE = 2 };
/* An output: done; Python looks at it; C cannot evaluate it; F may have jumped before it, it is not done. */
enum { HARMLESS = 0, LOOKED_AT = 1, NOT_SHOWN = 2, SUSPECT = 3 };
/* Newton's iteration of a load level. */
enum { FOUND = 0, ANOTHER_WAY = 1, NOT_A_NUMBER = 2, TOO_LARGE = 3, GROWING = 4, NO_END = 5 };

/* Of Python's stable C interface; GetItem borrows, DecRef does nothing for NULL. */
#define PYTHON_FUNCTIONS(F) \
    F(int, PyGILState_Ensure, (void)) \
    F(void, PyGILState_Release, (int)) \
    F(void *, PyLong_FromLong, (long)) \
    F(void *, PyFloat_FromDouble, (double)) \
    F(double, PyFloat_AsDouble, (void *)) \
    F(void *, PyObject_CallFunctionObjArgs, (void *, ...)) \
    F(int, PyObject_IsTrue, (void *)) \
    F(void *, PyObject_Type, (void *)) \
    F(ptrdiff_t, PyList_Size, (void *)) \
    F(ptrdiff_t, PyTuple_Size, (void *)) \
    F(void *, PyList_GetItem, (void *, ptrdiff_t)) \
    F(void *, PyTuple_GetItem, (void *, ptrdiff_t)) \
    F(void, Py_DecRef, (void *)) \
    F(void *, PyErr_Occurred, (void)) \
    F(int, PyErr_ExceptionMatches, (void *)) \
    F(void, PyErr_Clear, (void)) \
    F(void, PyErr_Fetch, (void **, void **, void **)) \
    F(void, PyErr_NormalizeException, (void **, void **, void **)) \
    F(int, PyException_SetTraceback, (void *, void *))

#define MEMBER(result, name, arguments) result (*name) arguments;
typedef struct Python {
    PYTHON_FUNCTIONS(MEMBER)
    void *real_type, *numpy_real, *whole_type, *list_type, *tuple_type, *exception;
} Python;

/* 0; 1 when the state cannot be evaluated; 2 when all has to end: Python keeps the error. f NULL: an accepted step
   is told. */
typedef int (*AskRate)(double t, const double *y, double *f);

/* The state y at a time in the last step: 0, or 2 when Python keeps an error. */
typedef int (*Value)(double t, double *y);

typedef int (*Back)(int what, int batch, double t);
typedef void *(*Unwrap)(void *, const char *);

typedef struct {
    int kind, n, nxe, nee, np;
    const double *p; /* (np, n) */
} Elements;

/* A batch that Python evaluates: with the elements last, as its families have them. */
typedef struct {
    real *x, *v, *branch;      /* (nxe, n), (nxe, n), (nee, n): where */
    real *e, *V, *H, *M, *h; /* (nee, n), (nee, nxe, n), (nee, n), (nxe, nxe, n), (nxe, n): the answers */
} Foreign;

/* What a user function is told, and what it answers: forces (nx), stresses (ne).
   lost: whether there have been sentences about stresses that cannot act: then Python is asked at outputs. */
typedef struct { real *x, *xd, *force, *e, *ed, *sigma; int lost; } User;

/* Rows of an answer: their two leading numbers, and their places in e or x. */
typedef struct { double first, second, place; } Row;

typedef struct {
    const Python *python;
    double *sigma, *force;      /* where the answers of a user function that C calls are written */
    int n_sigma;                /* rows of stresses as those of an earlier answer; negative: none are known */
    /* the user function of a single case, or NULL; what it is called with, behind the time */
    void *function, *told[8];
    Back back;                  /* where there is no `python`: callback of ctypes, not 0 when C has to stop */
    /* called with the same, true when C has to stop; with what was raised; with the time and an answer */
    void *answer, *keep, *read;
    const Row *rows;            /* of stresses and behind them of forces */
    double t;                   /* of the last question to `function` */
    int n_force;
    /* whether `function` itself has raised; set by what is no Exception: nobody is asked any more */
    int within, stopped;
} PythonCallbacks;

/* The last evaluated state, shared with Python; (nx) or (ne). A model may have several, each on its own path. */
typedef struct {
    /* rates and accelerations too, at t; 2: placed from outside, with no transfer functions */
    int known;
    double t;
    real *x, *xd, *xdd, *e, *ed, *edd, *sigma, *given_e; /* xd and xdd stand behind x */
    real *applied, *gravity, *total, *y;  /* forces (nx) and the state that belong to it where it is whole */
    /* number of the evaluation that gave all of it; Python sets it to 0 when it writes here */
    int64_t whole;
    /* watched: derivatives keep the two below; 1: det V[E, U] was positive, 2: negative */
    int watched, signs;
    /* of the inverse of its smallest size since these were cleared: mantissa 2^exponent */
    double mantissa, exponent;
} State;

/* What the steps of a method share. */
typedef struct {
    Model *model;
    State *at;
    AskRate ask;
    /* (capacity, width) of the last accepted steps: t, sign, size of the determinant, known, y, x, xd, xdd, e */
    double *records;
    const double *scale;     /* (nx) of the coordinates whose velocities are compared */
    const double *atol;      /* (n) absolute error of every component of the state */
    int n, capacity, width, look, back, most, max_reductions;
    double reduction, stretch, rtol, longest, converged, jump, earliest, latest, half, inside, wide, far;
    double share, noise, still;
    double t, t_end, until, h, error, peak; /* peak: largest determinant since its last minimum */
    double begin, sizes[2];  /* of the last step; sizes of it and of the one before */
    int recorded, entered;   /* accepted steps in the records; entered: look always, as a dead point is being left */
    int n_steps, n_rhs, n_rejected, reductions;
    const int *lambda0;      /* of several cases: coordinates that may not come to zero, here nearer than half_turn */
    double half_turn, signs[8]; /* signs of the determinants at the last accepted step */
    int n_lambda0;
} Stepper;

typedef struct {
    /* (2 MAX_ORDER + 8, n) of the object in Python: phi, expected, y ... behind one another */
    double *memory;
    const double *gamma_star;                 /* (MAX_ORDER + 2) */
    double *phi, *expected;                   /* (MAX_ORDER + 1, n) */
    double *y, *y_new, *predicted, *d, *weight; /* (n) */
    double psi[ORDERS], h_old, h_min;
    int k, order, k_old, equal, starting, rejections; /* k: of the last step; order: of the next one */
} Adams;

typedef struct {
    const double *c, *a, *b, *errors;   /* (rows), (rows, rows), (stages), (1 or 2, rows of the estimate) */
    double *K, *y, *y_new, *scaled;     /* (stages + 1, n), (n) each; scaled: the error over the tolerance */
    double exponent, smallest, largest, safety, tiny, h; /* of the step control; h: size of the last step */
    /* rows: stages evaluated together; estimated: rows of the estimate; two of them */
    int stages, rows, estimated, two;
} RungeKutta;

typedef struct {
    const double *c, *a, *inverse, *to, *back; /* (s), (s, s) each */
    const double *lu, *pair_lu[2];             /* (nu, nu), pairs of numbers of the complex systems */
    const int *pivots, *pair_pivots[2];
    const double *y, *weight;                  /* (n) */
    double *Z, *F, *change, *right;            /* (s, n), (s, n), (s, n), (s, nu) */
    double t, h, earliest, latest, converged, jump, kappa; /* kappa: of `size`, where the iteration ends */
    double contraction, size, theta;           /* size of the last change */
    int s, n, nq, most, iterations, n_rhs;
} Newton;

typedef struct {
    State *shown;
    const double *t;           /* (n) times of the outputs to come */
    /* (n, width): x, xd, xdd, applied, gravity, total forces; e, ed, edd, sigma; y where it has no place of its own */
    double *rows;
    /* (n, 5) steps, derivatives, 0, rejected steps, 0 since the output before: `Counts` of problem.py */
    int *work;
    const int *ground;         /* (n_ground) rows of sigma that may press but not pull */
    Value value;               /* NULL: that of Adams */
    double *y;                 /* of several cases: room for the state at an output */
    double *around;            /* (2, n of y) room for states beside an output */
    const int *rates;          /* (n of rates) places of the accelerations of the state in a row */
    double suspect;            /* 0, or d of spacar/integrators/drive.py from which on an output is not shown */
    /* limits of a position, a jump, 1/condition, guards of elements; seconds */
    double exact, jump, singular, guard, longest;
    int n, done, width, since, far, n_exact, n_ground, foreign, steps, n_rates;
    int last, status;          /* how the last output came out, and its evaluation */
    int counted[5];            /* what Stepper had counted at the last output of this call */
} OutputBlock;

typedef struct {
    Model *model;
    State *at;
    const int *read, *load;       /* places behind x of the state, and behind the forces of the model */
    const double *matrix;         /* (n_load + n_states, 1 + n_given + n_states + n_read) */
    double *z, *own, *rates;      /* of the product; y and y' of the mechanism */
    int n_read, n_load, n_given, n_states;
    double converged, jump;
} Loop;

/* The elements of one type. */
typedef struct {
    const Elements *elements;
    const int64_t *x, *e;      /* (nxe, n), (nee, n) places */
    double *V;                 /* (nee, nxe, n) */
    const double *S;           /* (nee, nee, n) stiffness; NULL: none */
    int64_t curved, heavy;     /* V depends on x; gravity depends on x */
} Group;

/* Coordinates: the first `x_free` and the n_x_input from `x_input` on are not free. Deformations: the first e_input
   and the n_e_input behind them are given. */
typedef struct {
    const Group *groups;
    /* (nx) start and size, (ne) size, (nx) least size where lengths are compared */
    const double *x0, *scale, *e_scale, *least;
    /* two parts, of which `parts` is taken: force (nx), gravity (nx), preload (ne), steps of what is prescribed */
    const double *loads;
    const double *held;        /* (nx + ne) or NULL: forces and misfits of deformations of which `hold` is taken */
    double *branch, *e;          /* (ne) of the sweep */
    int64_t nx, ne, nf, n_groups, x_free, x_input, n_x_input, e_input, n_e_input, heavy, widest, dense;
    double size, parts[2], hold;
    double floor, singular, no_digits, spread, first_ratio, later_ratio, jump, symmetric, guess_forces, guess_lengths,
        weight, safe;
    /* what an iteration has to reach, from where, and what comes out */
    double forces, lengths, correction, tolerance;
    /* out: x, sigma, right, rounding; (limit) */
    double *x, *sigma, *out, *sizes;
    int64_t limit, iterations, quiet;
    double work_force, work, work_size, gap, noise, sign;
    void *own;
} Equilibrium;

#define STRUCTURES(F) \
    F(Elements) F(Foreign) F(User) F(Row) F(PythonCallbacks) F(State) F(Stepper) F(Adams) F(RungeKutta) F(Newton) \
      F(OutputBlock) F(Loop) \
    F(Group) F(Equilibrium)

/* Result, name behind spacar_, arguments: of a model and its motion; of batches of elements and of states at rest. */
#define FUNCTIONS(F) \
    F(Model *, begin, (const int *whole, real *numbers, const Foreign *const *foreign, const User *user, \
      PythonCallbacks *asking)) \
    F(void, end, (Model *m)) \
    F(void, capsules, (Unwrap pointer)) \
    F(void, dropped, (void *capsule)) \
    F(void, renew, (Model *m)) \
    F(int, too_large, (Model *m)) \
    F(void, state, (const Model *m, State *at, real *memory)) \
    F(int, start, (Model *m, State *at, const real *y, real *out, double converged, double jump, double farthest, \
      int checked)) \
    F(int, evaluate, (Model *m, State *at, double t, const real *y, double converged, double jump)) \
    F(int, rhs, (Model *m, State *at, double t, const real *y, real *out, double converged, double jump)) \
    F(int, stages, (Model *m, State *at, int from, int n, const double *c, const double *a, double t, double h, \
      double earliest, double latest, const real *y, real *K, int stride, double converged, double jump)) \
    F(void, forget, (Model *m)) \
    F(int, gradient, (Model *m, int *row, int *column, real *value)) \
    F(void, determinant, (Model *m, double *mantissa, double *exponent)) \
    F(int, reduced_mass, (Model *m, real *out)) \
    F(double, guard, (const Model *m, const real *x)) \
    F(double, rcond, (Model *m, double enough, int most)) \
    F(double, rcond_everywhere, (const Model *m)) \
    F(int, adams_begin, (Stepper *r, Adams *a)) \
    F(int, adams, (Stepper *r, Adams *a)) \
    F(int, adams_value, (const Stepper *r, const Adams *a, double t, double *out)) \
    F(int, runge_kutta, (Stepper *r, RungeKutta *p)) \
    F(int, newton, (Model *m, State *at, Newton *r)) \
    F(int, show, (Model *m, OutputBlock *p)) \
    F(int, pass_adams, (Stepper *r, Adams *a, OutputBlock *p)) \
    F(int, pass_runge_kutta, (Stepper *r, RungeKutta *k, OutputBlock *p)) \
    F(int, loop_stages, (const Loop *l, int from, int n, const double *c, const double *a, double t, double h, \
      double earliest, double latest, const double *given, const double *y, double *K, int stride, double *stage))

#define ELEMENT_FUNCTIONS(F) \
    F(void, elements_strain, (const Elements *k, const double *x, const double *branch, double *e, double *V)) \
    F(void, elements_convective, (const Elements *k, const double *x, const double *v, double *h)) \
    F(void, elements_inertia, (const Elements *k, const double *x, const double *v, const double *a, double *M, \
      double *f)) \
    F(void, elements_geometric, (const Elements *k, const double *x, const double *sigma, double *Hs)) \
    F(void, elements_rates, (const Elements *k, const double *x, const double *v, int second, double *H1)) \
    F(void, elements_transport, (const Elements *k, const double *x, const double *v, double *H2)) \
    F(void, elements_inertia_gradient, (const Elements *k, const double *x, const double *v, const double *a, \
      double *by_x, double *by_v)) \
    F(double, elements_guard, (const Elements *k, const double *x)) \
    F(int, equilibrium_begin, (Equilibrium *q)) \
    F(void, equilibrium_end, (Equilibrium *q)) \
    F(int, equilibrium_newton, (Equilibrium *q)) \
    F(int, equilibrium_point, (Equilibrium *q)) \
    F(int, equilibrium_factor, (Equilibrium *q)) \
    F(double, equilibrium_sign, (const Equilibrium *q)) \
    F(int, equilibrium_definite, (Equilibrium *q)) \
    F(int, band_inverse, (const double *a, int n, int b, const int *pivots, double *diagonal))
