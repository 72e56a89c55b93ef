/* What Python gives, a model, and its elements: strains, convective terms, inertia, guards. STRAIN, CONVECTIVE, ... are
   the tables at the end of kernels.c; a batch without functions there is asked of Python (`Foreign`). All vectors are
   in the order of the result files. V and M are lists of the entries of the elements. */

typedef struct {
    int kind, n, nxe, nee, np, inertia; /* kind -1: foreign; inertia: M and h depend on x */
    const int *x, *e;                   /* (n, nxe), (n, nee) */
    const real *p;                      /* (n, np) */
    const Foreign *foreign;
} Batch;

/* What Python gives, in two arrays: `read_spec` of model.c. */
typedef struct {
    int nx, ne, n_fixed_x, n_rows, n_equations, n_batches, n_stiffness, n_damping, prescribed, n_constant;
    int x_input, n_x_input, x_dynamic, n_x_dynamic, x_kinematic, n_x_kinematic;
    int e_input, n_e_input, e_dynamic, n_e_dynamic, e_kinematic, n_e_kinematic;
    int polynomial, n_position, n_moments, n_coupled, max_iterations; /* up to here as they are given */
    int n_free;
    const Batch *batches;
    const int *constant_row, *constant_column; const real *constant_mass; /* (n_constant) */
    const double *scale, *e_scale;        /* (nx), (ne) sizes */
    const struct { double converged, rounding, grown; } *criteria; /* of spacar/kinematics/kinematics.py */
    const real *force, *field, *preload;  /* (nx) constant forces without gravity, (nx) gravity field, (ne) */
    const int *s_rows, *s_columns, *d_rows, *d_columns;
    const real *s_values, *d_values;
    const int *moment_rows, *moment_columns; const real *moments; /* (n_moments) of forces that are linear in x */
    const int *coupled_rows, *coupled_columns; const real *coupled; /* (n_coupled) of MEE: M_e of deformations */
    const int *free;                      /* (n_free) coordinates that are not fixed or prescribed */
    const int *position;                  /* (n_position) the rows of e that are given: without slips */
    const int *translation;               /* (nx) its number, of joined position nodes along an axis; -1: a rotation */
    const real *x0;                       /* (nx) reference configuration: the values of fixed coordinates */
    const real *x_motion, *e_motion;      /* (n, 3): start, rate, acceleration; or value, rate, acceleration at t */
    const User *user;                     /* NULL: no user function */
    PythonCallbacks *asking;                       /* NULL where nothing is asked of Python */
} Spec;

enum { STATES = 3 }; /* from which a guess goes on */

/* What is remembered of a state: of the last n evaluations with different times, the last first, the times, the
   degrees of freedom, their rates and accelerations (3 q); x, xd, xdd (3 nx) of those before the last. */
typedef struct { const State *of; int n; double t[STATES]; real *degrees[STATES], *before[STATES - 1]; } Trace;

struct Model {
    /* of what stays with the model; of the tree, which other numbers may change */
    Memory memory, tree_memory;
    Spec s;
    /* how many there were; also told of numbers that have changed (`spacar_forget`) */
    int64_t evaluations;
    int factored;                         /* the matrix of the position is that of some state before */
    int holonomic;                        /* positions and velocities have the same matrix */
    int *v_start, *v_column; /* V by rows: the places in `values` are those of v_column */
    int *v_offset, *m_offset;             /* (number of elements) places of the element matrices */
    Entries mass, given;                  /* of M; of M where the acceleration is given: gravity, prescribed motion */
    Entries dynamic;                      /* of V, in the columns of dynamic coordinates, counted from the first one */
    Entries coupling;                     /* of V^T M_e V; the factors of entry k are at first[k], second[k] */
    int *coupling_first, *coupling_second; real *coupling_weight;
    int reduced, width;                   /* accelerations from the reduced form; numbers in a row of `transfer` */
    const State *transfer_of;             /* the state that `transfer` belongs to */
    /* of a motion and of its outputs, or of two companions; the first one is the last used */
    Trace traces[2];
    Sparse position, velocity, motion;    /* `velocity` where it is not that of the position */
    real *values;                         /* V, then M of moving elements, then the constant M */
    real *factored_x;                     /* (nx) where the matrix of the position is the factored one */
    /* next_xd and next_xdd stand behind next_x, as those of a State */
    real *h, *convected, *applied, *b, *force, *next_x, *next_xd, *next_xdd, *branch, *next_e, *given_ed, *given_edd,
        *stage, *piece;
    real *transfer, *weighted, *small;
    int *v_place;                         /* (n_v) order of V's rows: place in `values` */
    int *m_start, *m_column, *m_place;    /* M by rows in the same way, for the reduced form */
    int *places; real *parameters;        /* of the batches */
    const real *given_parameters;         /* the same as they are given */
    struct Tree *tree; int of_tree;       /* NULL: not a rigid tree; of_tree: the last state was evaluated as one */
    int matrices_behind, factors_behind;  /* V and M, the factors of the position are those of an older state */
    Sparse first[3];                      /* the systems with the orders of pivots that other numbers begin with */
};

/* Add as many whole turns to e of one element as bring its angle closest to `branch`. */
static inline void unwind(const Batch *k, const real *x, real branch, const real *p, real *e)
{
    real turn[MAX_E], angle = e[0], count = EVERY(0.0);
    WHOLE_TURN[k->kind](p, turn);
    if (ANGLE[k->kind]) ANGLE[k->kind](x, e, p, &angle);
    EACH_LANE if (LANE(turn[0], w) != 0.0) LANE(count, w) = rint((LANE(branch, w) - LANE(angle, w)) / (2.0 * M_PI));
    for (int r = 0; r < k->nee; r++) e[r] += count * turn[r];
}

/* What the branch of states after x, e is chosen by, (ne): deformations, or the angle that is counted. */
static void follow(const Model *m, const real *x, const real *e, real *branch)
{
    real xe[MAX_X], ee[MAX_E];
    memcpy(branch, e, sizeof(real) * m->s.ne);
    for (int b = 0; b < m->s.n_batches; b++) {
        const Batch *k = &m->s.batches[b];
        if (k->foreign || !ANGLE[k->kind]) continue;
        for (int i = 0; i < k->n; i++) {
            const int *ie = k->e + i * k->nee;
            for (int j = 0; j < k->nxe; j++) xe[j] = x[k->x[i * k->nxe + j]];
            for (int r = 0; r < k->nee; r++) ee[r] = e[ie[r]];
            ANGLE[k->kind](xe, ee, k->p + i * k->np, &branch[ie[0]]);
        }
    }
}

/* e, and V into `values`. OK or NOT_ANSWERED. */
static int strain(const Model *m, const real *x, const real *branch, real *e)
{
    real xe[MAX_X], ee[MAX_E];
    const int *offset = m->v_offset;
    for (int b = 0; b < m->s.n_batches; b++) {
        const Batch *k = &m->s.batches[b];
        const int n = k->n;
        if (k->foreign && k->nee) {
            const Foreign *f = k->foreign;
            for (int i = 0; i < n; i++) for (int j = 0; j < k->nxe; j++) f->x[j * n + i] = x[k->x[i * k->nxe + j]];
            for (int i = 0; i < n; i++) for (int r = 0; r < k->nee; r++)
                f->branch[r * n + i] = branch[k->e[i * k->nee + r]];
            if (ask(m->s.asking, ASK_STRAIN, b, 0.0)) return NOT_ANSWERED;
            for (int i = 0; i < n; i++) for (int r = 0; r < k->nee; r++) e[k->e[i * k->nee + r]] = f->e[r * n + i];
            memcpy(m->values + *offset, f->V, sizeof(real) * n * k->nee * k->nxe);
        }
        if (k->foreign) { offset += n; continue; }
        for (int i = 0; i < n; i++, offset++) {
            if (!k->nee) continue;
            const int *ix = k->x + i * k->nxe, *ie = k->e + i * k->nee;
            for (int j = 0; j < k->nxe; j++) xe[j] = x[ix[j]];
            STRAIN[k->kind](xe, k->p + i * k->np, ee, m->values + *offset);
            if (WHOLE_TURN[k->kind]) unwind(k, xe, branch[ie[0]], k->p + i * k->np, ee);
            for (int r = 0; r < k->nee; r++) e[ie[r]] = ee[r];
        }
    }
    return OK;
}

/* The values of V^T M_e V, from those of V. */
static void couple(const Model *m)
{
    for (int k = 0; k < m->coupling.n; k++)
        m->values[m->coupling.source[k]] =
            m->coupling_weight[k] * m->values[m->coupling_first[k]] * m->values[m->coupling_second[k]];
}

static inline void subtract_transposed(const Model *m, int r, real sigma, real *out);

/* H(v,v) when wanted, and M into `values` with h of the moving elements. OK or NOT_ANSWERED. */
static int inertia(const Model *m, const real *x, const real *v, int want_convective)
{
    real xe[MAX_X], ve[MAX_X], he[MAX_X];
    const int *offset = m->m_offset;
    memset(m->convected, 0, sizeof(real) * m->s.nx);
    for (int b = 0; b < m->s.n_batches; b++) {
        const Batch *k = &m->s.batches[b];
        const int n = k->n;
        if (k->foreign) {
            const Foreign *f = k->foreign;
            for (int i = 0; i < n; i++)
                for (int j = 0; j < k->nxe; j++) {
                    f->x[j * n + i] = x[k->x[i * k->nxe + j]];
                    f->v[j * n + i] = v[k->x[i * k->nxe + j]];
                }
            if (k->nee) {
                if (ask(m->s.asking, ASK_CONVECTIVE, b, 0.0)) return NOT_ANSWERED;
                for (int i = 0; i < n; i++) for (int r = 0; r < k->nee; r++)
                    m->h[k->e[i * k->nee + r]] = f->H[r * n + i];
            }
            if (k->inertia) {
                if (ask(m->s.asking, ASK_INERTIA, b, 0.0)) return NOT_ANSWERED;
                memcpy(m->values + *offset, f->M, sizeof(real) * n * k->nxe * k->nxe);
                for (int i = 0; i < n; i++)
                    for (int j = 0; j < k->nxe; j++) m->convected[k->x[i * k->nxe + j]] += f->h[j * n + i];
            }
            offset += n;
            continue;
        }
        for (int i = 0; i < n; i++, offset++) {
            if (!k->inertia && !(k->nee && want_convective)) continue;
            const int *ix = k->x + i * k->nxe;
            const real *p = k->p + i * k->np;
            for (int j = 0; j < k->nxe; j++) { xe[j] = x[ix[j]]; ve[j] = v[ix[j]]; }
            if (k->nee && want_convective) {
                real rates[MAX_E];
                CONVECTIVE[k->kind](xe, ve, p, rates);
                for (int r = 0; r < k->nee; r++) m->h[k->e[i * k->nee + r]] = rates[r];
            }
            if (!k->inertia) continue;
            INERTIA[k->kind](xe, ve, p, m->values + *offset, he);
            for (int r = 0; r < k->nxe; r++) m->convected[ix[r]] += he[r];
            if (!FLOW[k->kind]) continue;
            FLOW[k->kind](xe, ve, p, he);
            for (int r = 0; r < k->nxe; r++) m->convected[ix[r]] += he[r];
        }
    }
    couple(m);
    for (int k = 0; k < m->s.n_coupled; k++)
        subtract_transposed(m, m->s.coupled_rows[k], -m->s.coupled[k] * m->h[m->s.coupled_columns[k]], m->convected);
    return OK;
}

/* Row r of V times v. */
static inline real rate(const Model *m, int r, const real *v)
{
    real sum = EVERY(0.0);
    for (int k = m->v_start[r]; k < m->v_start[r + 1]; k++) sum += m->values[m->v_place[k]] * v[m->v_column[k]];
    return sum;
}

static inline void subtract_transposed(const Model *m, int r, real sigma, real *out)
{
    for (int k = m->v_start[r]; k < m->v_start[r + 1]; k++) out[m->v_column[k]] -= m->values[m->v_place[k]] * sigma;
}

/* Smallest guard of all elements and lanes at x; 1 when there are none. Python knows of the foreign ones. */
static double spacar_guard(const Model *m, const real *x)
{
    real xe[MAX_X], g[MAX_GUARDS];
    double least = 1.0;
    for (int b = 0; b < m->s.n_batches; b++) {
        const Batch *k = &m->s.batches[b];
        const int n = k->foreign ? 0 : N_GUARDS[k->kind];
        for (int i = 0; n && i < k->n; i++) {
            for (int j = 0; j < k->nxe; j++) xe[j] = x[k->x[i * k->nxe + j]];
            GUARD[k->kind](xe, k->p + i * k->np, g);
            for (int r = 0; r < n; r++) EACH_LANE if (!(LANE(g[r], w) >= least)) least = LANE(g[r], w);
        }
    }
    return least;
}
