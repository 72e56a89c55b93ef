/* One evaluation of the equations of motion of a holonomic mechanism (theory-system.md (1), (2), (9)).

   All vectors are in the order of the result files. V and M are lists of the entries of the elements. The accelerations come
   from the saddle-point form, or with few degrees of freedom from the reduced form, whose transfer functions need nothing but
   solutions with the matrix of the position; stresses are computed where somebody looks at them. */
enum { PLBEAM, PLTRUSS, PLTOR, PLPINBOD, BEAM, TRUSS, HINGE, PINBODY, NORMALIZATION, BODY };
enum { MAX_ITERATIONS = 20, MAX_X = 14, MAX_E = 6, MAX_GUARDS = 4 };
static const double SMALLEST_PIECE = 1.0 / 64.0;

typedef struct {
    int kind, n, nxe, nee, np, inertia; /* inertia: M and h depend on x */
    const int *x, *e;                   /* (n, nxe), (n, nee) */
    const real *p;                      /* (n, np) */
} Batch;

typedef struct { int n, *row, *column, *source; } Entries; /* (n) each; `source` is a place in `values` */

/* What Python gives. */
typedef struct {
    int nx, ne, n_fixed_x, n_rows, n_equations, n_batches, n_stiffness, n_damping, prescribed, n_constant, n_free;
    int x_input, n_x_input, x_dynamic, n_x_dynamic, e_input, n_e_input, e_dynamic, n_e_dynamic, polynomial;
    const Batch *batches;
    const int *constant_row, *constant_column; const real *constant_mass; /* (n_constant) */
    const double *scale;                  /* (nx) sizes */
    const real *force, *field, *preload;  /* (nx) constant forces without gravity, (nx) gravity field, (ne) */
    const int *s_rows, *s_columns, *d_rows, *d_columns;
    const real *s_values, *d_values;
    const int *free;                      /* (n_free) coordinates that are not fixed or prescribed */
    const real *x0;                       /* (nx) reference configuration: the values of fixed coordinates */
    const real *x_motion, *e_motion;      /* (n, 3): start, rate, acceleration; or value, rate, acceleration at t */
} Spec;

/* The last evaluated state, shared with Python; (nx) or (ne). A model may have several, each on its own path. */
typedef struct {
    int known;                            /* rates and accelerations too, at t */
    double t;
    real *x, *xd, *xdd, *e, *ed, *edd, *sigma, *given_e;
} State;

typedef struct {
    Spec s;
    int factored;                         /* the matrix of the position is that of some state before */
    int n_v, n_values, *v_start, *v_column; /* V by rows: the places in `values` are those of v_column */
    int *v_offset, *m_offset;             /* (number of elements) places of the element matrices */
    Entries mass, dynamic;                /* of M; of V, in the columns of dynamic coordinates, counted from the first one */
    int reduced, width;                   /* accelerations from the reduced form; numbers in a row of `transfer` */
    Sparse position, motion;
    real *values;                         /* V, then M of moving elements, then the constant M */
    real *h, *convected, *b, *force, *next_x, *next_xd, *next_xdd, *near, *next_e, *given_ed, *given_edd, *stage, *piece, *transfer, *weighted, *small;
    int *v_place;                         /* (n_v) order of V's rows: place in `values` */
} Model;

static void element_strain(int kind, const real *x, const real *p, real *e, real *V)
{
    switch (kind) {
    case PLBEAM: plbeam_strain(x, p, e, V); break;
    case PLTRUSS: pltruss_strain(x, p, e, V); break;
    case PLTOR: pltor_strain(x, p, e, V); break;
    case PLPINBOD: plpinbod_strain(x, p, e, V); break;
    case BEAM: beam_strain(x, p, e, V); break;
    case TRUSS: truss_strain(x, p, e, V); break;
    case HINGE: hinge_strain(x, p, e, V); break;
    case PINBODY: pinbody_strain(x, p, e, V); break;
    case NORMALIZATION: normalization_strain(x, p, e, V); break;
    }
}

static void element_convective(int kind, const real *x, const real *v, const real *p, real *h)
{
    switch (kind) {
    case PLBEAM: plbeam_convective(x, v, p, h); break;
    case PLTRUSS: pltruss_convective(x, v, p, h); break;
    case PLTOR: pltor_convective(x, v, p, h); break;
    case PLPINBOD: plpinbod_convective(x, v, p, h); break;
    case BEAM: beam_convective(x, v, p, h); break;
    case TRUSS: truss_convective(x, v, p, h); break;
    case HINGE: hinge_convective(x, v, p, h); break;
    case PINBODY: pinbody_convective(x, v, p, h); break;
    case NORMALIZATION: normalization_convective(x, v, p, h); break;
    }
}

static void element_inertia(int kind, const real *x, const real *v, const real *p, real *M, real *h)
{
    switch (kind) {
    case PLBEAM: plbeam_inertia(x, v, p, M, h); break;
    case BEAM: beam_inertia(x, v, p, M, h); break;
    case BODY: body_inertia(x, v, p, M, h); break;
    }
}

/* Guards of an element; their number. */
static int element_guard(int kind, const real *x, const real *p, real *g)
{
    switch (kind) {
    case PLBEAM: plbeam_guard(x, p, g); return 3;
    case PLTRUSS: pltruss_guard(x, p, g); return 1;
    case BEAM: beam_guard(x, p, g); return 4;
    case TRUSS: truss_guard(x, p, g); return 1;
    }
    return 0;
}

/* e, and V into `values`. */
static void strain(const Model *m, const real *x, const real *near, real *e)
{
    real xe[MAX_X], ee[MAX_E];
    const int *offset = m->v_offset;
    for (int b = 0; b < m->s.n_batches; b++) {
        const Batch *k = &m->s.batches[b];
        for (int i = 0; i < k->n; i++, offset++) {
            if (!k->nee) continue;
            const int *ix = k->x + i * k->nxe, *ie = k->e + i * k->nee;
            for (int j = 0; j < k->nxe; j++) xe[j] = x[ix[j]];
            element_strain(k->kind, xe, k->p + i * k->np, ee, m->values + *offset);
            if (k->kind == HINGE) ee[0] += 2 * M_PI * lanes_rint((near[ie[0]] - ee[0]) / (2 * M_PI));
            for (int r = 0; r < k->nee; r++) e[ie[r]] = ee[r];
        }
    }
}

/* H(v,v), and M into `values` with h of the moving elements. */
static void inertia(const Model *m, const real *x, const real *v)
{
    real xe[MAX_X], ve[MAX_X], he[MAX_X];
    const int *offset = m->m_offset;
    memset(m->convected, 0, sizeof(real) * m->s.nx);
    for (int b = 0; b < m->s.n_batches; b++) {
        const Batch *k = &m->s.batches[b];
        for (int i = 0; i < k->n; i++, offset++) {
            const int *ix = k->x + i * k->nxe;
            const real *p = k->p + i * k->np;
            for (int j = 0; j < k->nxe; j++) { xe[j] = x[ix[j]]; ve[j] = v[ix[j]]; }
            if (k->nee) {
                real rates[MAX_E];
                element_convective(k->kind, xe, ve, p, rates);
                for (int r = 0; r < k->nee; r++) m->h[k->e[i * k->nee + r]] = rates[r];
            }
            if (!k->inertia) continue;
            element_inertia(k->kind, xe, ve, p, m->values + *offset, he);
            for (int r = 0; r < k->nxe; r++) m->convected[ix[r]] += he[r];
        }
    }
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

/* Position and velocity. x comes with the given values and a guess of the calculable ones, xd and ed with the given rates.
   The first correction uses the matrix of the last state, which is still factored. One that follows a correction below
   CONVERGED is as small as rounding allows and passes always. */
static const double CONVERGED = 1e-11;

static int place(Model *m, real *x, real *xd, real *e, const real *near, const real *e_given, const real *e_rate,
                 double converged)
{
    const int n = m->s.n_equations, first = m->s.n_fixed_x;
    real *r = m->b;
    double before = INFINITY, last = INFINITY;
    int halvings = 0;
    for (int iteration = 1; iteration <= MAX_ITERATIONS; iteration++) {
        strain(m, x, near, e);
        real residual = EVERY(0.0), total = EVERY(0.0);
        for (int i = 0; i < n; i++) {
            const real difference = e[i] - e_given[i];
            residual = lanes_larger(residual, difference);
            total += difference;
        }
        const double norm = largest_lane(residual);
        if (!isfinite(norm) || !isfinite(largest_lane(total))) return NOT_FINITE;
        if (norm > 2.0 * before && norm > 1e-6) {
            if (++halvings > 5) return NO_CONVERGENCE;
            for (int i = 0; i < n; i++) { r[i] *= 0.5; x[first + i] += r[i]; }
            continue;
        }
        before = norm;
        halvings = 0;
        for (int i = 0; i < n; i++) r[i] = e[i] - e_given[i];
        const int chord = iteration == 1 && m->factored && norm > converged;
        const int status = chord ? OK : factor(&m->position, m->values);
        m->factored = !status;
        if (status) return status;
        solve(&m->position, r, r);
        real step = EVERY(0.0), sum = EVERY(0.0);
        for (int i = 0; i < n; i++) {
            x[first + i] -= r[i];
            step = lanes_larger(step, r[i] / m->s.scale[first + i]);
            sum += r[i];
        }
        const double largest = largest_lane(step);
        if (!isfinite(largest) || !isfinite(largest_lane(sum))) return NOT_FINITE;
        if (chord) continue;
        if (largest > converged && last > CONVERGED) { last = largest; continue; }
        memset(xd + first, 0, sizeof(real) * n);
        for (int i = 0; i < n; i++) r[i] = e_rate[i] - rate(m, i, xd);
        solve(&m->position, r, xd + first);
        return iteration;
    }
    return NO_CONVERGENCE;
}

static void stresses(const Model *m, const real *e, const real *xd, real *sigma)
{
    const Spec *s = &m->s;
    memcpy(sigma, s->preload, sizeof(real) * s->ne);
    for (int i = 0; i < s->n_stiffness; i++) sigma[s->s_rows[i]] += s->s_values[i] * e[s->s_columns[i]];
    for (int i = 0; i < s->n_damping; i++) sigma[s->d_rows[i]] += s->d_values[i] * rate(m, s->d_columns[i], xd);
}

/* f + M g - h - M xdd_given - V^T sigma of the rows from first_row, at every coordinate. */
static void out_of_balance(const Model *m, const real *xdd, const real *sigma, int first_row, real *out)
{
    const Spec *s = &m->s;
    for (int i = 0; i < s->nx; i++) out[i] = s->force[i] - m->convected[i];
    for (int k = 0; k < m->mass.n; k++) {
        const int j = m->mass.column[k];
        out[m->mass.row[k]] += m->values[m->mass.source[k]] * (s->field[j] - xdd[j]);
    }
    for (int r = first_row; r < s->ne; r++) subtract_transposed(m, r, sigma[r], out);
}

/* Factor a positive definite matrix (n, n), rows `width` apart, and solve, in place; SINGULAR when a pivot is lost in rounding. */
static int solve_positive(real *A, int width, int n, real *b)
{
    for (int k = 0; k < n; k++) {
        const real diagonal = A[k * width + k];
        for (int j = 0; j < k; j++) A[k * width + k] -= A[k * width + j] * A[k * width + j];
        EACH_LANE if (!(LANE(A[k * width + k], w) > 1e-14 * LANE(diagonal, w))) return SINGULAR;
        A[k * width + k] = lanes_sqrt(A[k * width + k]);
        for (int i = k + 1; i < n; i++) {
            for (int j = 0; j < k; j++) A[i * width + k] -= A[i * width + j] * A[k * width + j];
            A[i * width + k] /= A[k * width + k];
        }
        for (int j = 0; j < k; j++) b[k] -= A[k * width + j] * b[j];
        b[k] /= A[k * width + k];
    }
    for (int k = n - 1; k >= 0; k--) {
        for (int j = k + 1; j < n; j++) b[k] -= A[j * width + k] * b[j];
        b[k] /= A[k * width + k];
    }
    return OK;
}

/* Reduced form: columns of `transfer` (nx, width) are the transfer functions of the q degrees of freedom and the acceleration
   without them, less gravity; zeros fill up the rows. xdd and, when wanted, sigma are completed from the given ones. */
static int reduced_form(Model *m, const real *edd_given, real *xdd, real *sigma, int want_stress)
{
    const Spec *s = &m->s;
    const int nx = s->nx, n = s->n_equations, first = s->n_fixed_x, a = s->n_x_dynamic, q = a + s->n_e_dynamic, width = m->width;
    real *X = m->transfer, *MX = m->weighted, *A = m->small, *b = A + q * width;
    real *right = X + first * width;
    memset(X, 0, sizeof(real) * nx * width);
    for (int k = 0; k < m->dynamic.n; k++)
        right[m->dynamic.row[k] * width + m->dynamic.column[k]] -= m->values[m->dynamic.source[k]];
    for (int i = a; i < q; i++) right[(s->e_dynamic + i - a) * width + i] = EVERY(1.0);
    for (int i = 0; i < n; i++) right[i * width + q] = edd_given[i] - m->h[i] - rate(m, i, xdd);
    solve_rows(&m->position, right, width);
    for (int i = 0; i < a; i++) X[(s->x_dynamic + i) * width + i] = EVERY(1.0);
    for (int i = 0; i < n; i++) xdd[first + i] = X[(first + i) * width + q];
    for (int i = 0; i < nx; i++) X[i * width + q] = xdd[i] - s->field[i];
    memset(MX, 0, sizeof(real) * nx * width);
    for (int k = 0; k < m->mass.n; k++)
        add_row(MX + m->mass.row[k] * width, m->values[m->mass.source[k]], X + m->mass.column[k] * width, width);
    real *force = m->force;
    for (int i = 0; i < nx; i++) force[i] = s->force[i] - m->convected[i] - MX[i * width + q];
    for (int r = s->n_rows; r < s->ne; r++) subtract_transposed(m, r, sigma[r], force);
    memset(A, 0, sizeof(real) * (q + 1) * width);
    for (int i = first; i < nx; i++) {
        for (int c = 0; c < q; c++) add_row(A + c * width, X[i * width + c], MX + i * width, width);
        add_row(b, force[i], X + i * width, width);
    }
    if (solve_positive(A, width, q, b)) return SINGULAR;
    for (int i = first; i < nx; i++)
        for (int c = 0; c < q; c++) xdd[i] += X[i * width + c] * b[c];
    real sum = EVERY(0.0);
    for (int i = first; i < nx; i++) sum += xdd[i];
    if (!isfinite(largest_lane(sum))) return NOT_FINITE;
    if (!want_stress) return OK;
    for (int i = first; i < first + n; i++)
        for (int c = 0; c < q; c++) force[i] -= MX[i * width + c] * b[c];
    solve_transposed(&m->position, force + first, m->b);
    memcpy(sigma, m->b, sizeof(real) * s->n_rows);
    return OK;
}

/* xdd comes with the given accelerations (zero elsewhere); it is completed, and so is sigma when wanted. The position system
   must be factored. */
static int accelerate(Model *m, const real *x, const real *xd, const real *e, const real *edd_given, real *xdd, real *sigma,
                      int want_stress)
{
    const Spec *s = &m->s;
    const int n = s->n_equations, nf = s->n_free, nr = s->n_rows;
    inertia(m, x, xd);
    stresses(m, e, xd, sigma);
    real *b = m->b, sum = EVERY(0.0);
    if (s->prescribed) { /* no dynamic degree of freedom: kinematics, then reactions from the transposed system */
        for (int i = 0; i < n; i++) b[i] = edd_given[i] - m->h[i] - rate(m, i, xdd);
        solve(&m->position, b, xdd + s->n_fixed_x);
        out_of_balance(m, xdd, sigma, n, m->force);
        solve_transposed(&m->position, m->force + s->n_fixed_x, sigma);
        for (int i = 0; i < n; i++) sum += sigma[i] + xdd[s->n_fixed_x + i];
        return isfinite(largest_lane(sum)) ? OK : NOT_FINITE;
    }
    if (m->reduced) return reduced_form(m, edd_given, xdd, sigma, want_stress);
    out_of_balance(m, xdd, sigma, nr, m->force);
    for (int i = 0; i < nf; i++) b[i] = m->force[s->free[i]];
    for (int r = 0; r < nr; r++) b[nf + r] = edd_given[r] - m->h[r] - rate(m, r, xdd);
    const int status = factor(&m->motion, m->values);
    if (status) return status;
    solve(&m->motion, b, b);
    for (int i = 0; i < nf; i++) { xdd[s->free[i]] = b[i]; sum += b[i]; }
    memcpy(sigma, b + nf, sizeof(real) * nr);
    return isfinite(largest_lane(sum)) ? OK : NOT_FINITE;
}

/* Value, rate and acceleration of a prescribed motion. */
static void prescribed(const Spec *s, const real *row, double t, real *value, real *rate, real *acceleration)
{
    *value = s->polynomial ? row[0] + t * (row[1] + 0.5 * t * row[2]) : row[0];
    *rate = s->polynomial ? row[1] + t * row[2] : row[1];
    *acceleration = row[2];
}

/* Evaluate the state y = (x dynamic, e dynamic, their rates) at t, stresses too when wanted. Number of position iterations, or a negative reason; then
   the last evaluated state is still there. The guess of the position is the Taylor expansion of the last state. */
static int evaluate(Model *m, State *at, double t, const real *y, double converged, double jump, int want_stress)
{
    const Spec *s = &m->s;
    const int nx = s->nx, first = s->n_fixed_x, n = s->n_equations, a = s->n_x_dynamic, q = a + s->n_e_dynamic;
    real *x = m->next_x, *xd = m->next_xd, *xdd = m->next_xdd;
    const double dt = at->known ? t - at->t : 0.0;
    memcpy(x, s->x0, sizeof(real) * nx);
    memset(xd, 0, sizeof(real) * nx);
    memset(xdd, 0, sizeof(real) * nx);
    real ahead = EVERY(0.0);
    for (int i = first; i < first + n; i++) {
        const real move = dt * (at->xd[i] + 0.5 * dt * at->xdd[i]);
        ahead = lanes_larger(ahead, move / s->scale[i]);
        x[i] = at->x[i] + move;
    }
    if (!(largest_lane(ahead) <= 0.5 * jump)) return JUMP; /* as FARTHEST_GUESS of the general path */
    for (int i = 0; i < s->n_x_input; i++) {
        const int k = s->x_input + i;
        prescribed(s, s->x_motion + 3 * i, t, &x[k], &xd[k], &xdd[k]);
    }
    for (int i = 0; i < s->n_e_input; i++) {
        const int k = s->e_input + i;
        prescribed(s, s->e_motion + 3 * i, t, &at->given_e[k], &m->given_ed[k], &m->given_edd[k]);
    }
    for (int i = 0; i < a; i++) { x[s->x_dynamic + i] = y[i]; xd[s->x_dynamic + i] = y[q + i]; }
    for (int i = a; i < q; i++) {
        at->given_e[s->e_dynamic + i - a] = y[i];
        m->given_ed[s->e_dynamic + i - a] = y[q + i];
    }
    memcpy(m->near, at->e, sizeof(real) * s->ne);
    memcpy(m->near, at->given_e, sizeof(real) * n); /* the rows that are given come first */
    const int iterations = place(m, x, xd, m->next_e, m->near, at->given_e, m->given_ed, converged);
    if (iterations < 0) return iterations;
    real moved = EVERY(0.0);
    for (int i = 0; i < nx; i++) moved = lanes_larger(moved, (x[i] - at->x[i]) / s->scale[i]);
    if (!(largest_lane(moved) <= jump)) return JUMP;
    const int status = accelerate(m, x, xd, m->next_e, m->given_edd, xdd, at->sigma, want_stress);
    if (status < 0) return status;
    memcpy(at->e, m->next_e, sizeof(real) * s->ne);
    memcpy(at->x, x, sizeof(real) * nx);
    memcpy(at->xd, xd, sizeof(real) * nx);
    memcpy(at->xdd, xdd, sizeof(real) * nx);
    at->t = t;
    at->known = 1;
    return iterations;
}

/* The same; a state that is a jump away is reached in pieces, so that the mechanism stays on its branch. */
int spacar_evaluate(Model *m, State *at, double t, const real *y, double converged, double jump, int want_stress)
{
    const Spec *s = &m->s;
    const int a = s->n_x_dynamic, q = a + s->n_e_dynamic;
    int status = evaluate(m, at, t, y, converged, jump, want_stress);
    for (double part = 0.5; status == JUMP && at->known && part >= SMALLEST_PIECE; part *= 0.5) {
        int reached = OK;
        while (reached >= 0 && status == JUMP) {
            for (int i = 0; i < a; i++) m->piece[i] = at->x[s->x_dynamic + i];
            for (int i = a; i < q; i++) m->piece[i] = at->e[s->e_dynamic + i - a];
            for (int i = 0; i < q; i++) m->piece[i] += part * (y[i] - m->piece[i]);
            memcpy(m->piece + q, y + q, sizeof(real) * q);
            reached = evaluate(m, at, at->t + part * (t - at->t), m->piece, converged, jump, 0);
            if (reached >= 0) status = evaluate(m, at, t, y, converged, jump, want_stress);
        }
    }
    return status;
}

/* Time derivative of y. */
int spacar_rhs(Model *m, State *at, double t, const real *y, real *out, double converged, double jump)
{
    const Spec *s = &m->s;
    const int status = spacar_evaluate(m, at, t, y, converged, jump, 0);
    if (status < 0) return status;
    const int a = s->n_x_dynamic, q = a + s->n_e_dynamic;
    memcpy(out, y + q, sizeof(real) * q);
    memcpy(out + q, at->xdd + s->x_dynamic, sizeof(real) * a);
    for (int i = a; i < q; i++) {
        const int r = s->e_dynamic + i - a;
        out[q + i] = rate(m, r, at->xdd) + m->h[r];
    }
    return status;
}

/* Stages `from` ... n - 1 of an explicit Runge-Kutta step from (t, y): K_i = F(t + c_i h, y + h sum_j a_ij K_j), at times not
   outside of [earliest, latest]. Rows of K are `stride` apart. The number of the first stage that could not be
   evaluated, n when all could. */
int spacar_stages(Model *m, State *at, int from, int n, const double *c, const double *a, double t, double h, double earliest,
                  double latest, const real *y, real *K, int stride, double converged, double jump)
{
    const int size = 2 * (m->s.n_x_dynamic + m->s.n_e_dynamic);
    for (int i = from; i < n; i++) {
        real *stage = m->stage;
        memset(stage, 0, sizeof(real) * size);
        for (int j = 0; j < i; j++)
            if (a[i * n + j] != 0.0)
                for (int k = 0; k < size; k++) stage[k] += a[i * n + j] * K[j * stride + k];
        for (int k = 0; k < size; k++) stage[k] = y[k] + h * stage[k];
        const double time = fmin(fmax(t + c[i] * h, earliest), latest);
        if (spacar_rhs(m, at, time, stage, K + i * stride, converged, jump) < 0) return i;
    }
    return n;
}

/* What frames have besides: rates of all deformations, gravity M g and total forces M xdd + h + V^T sigma. */
void spacar_complete(Model *m, State *at, real *gravity, real *total)
{
    const Spec *s = &m->s;
    for (int r = 0; r < s->ne; r++) {
        at->ed[r] = rate(m, r, at->xd);
        at->edd[r] = rate(m, r, at->xdd) + m->h[r];
    }
    memset(gravity, 0, sizeof(real) * s->nx);
    memcpy(total, m->convected, sizeof(real) * s->nx);
    for (int k = 0; k < m->mass.n; k++) {
        const real value = m->values[m->mass.source[k]];
        const int i = m->mass.row[k], j = m->mass.column[k];
        gravity[i] += value * s->field[j];
        total[i] += value * at->xdd[j];
    }
    for (int r = 0; r < s->ne; r++) subtract_transposed(m, r, -at->sigma[r], total);
}

/* Smallest guard of all elements and lanes at x; 1 when there are none. */
double spacar_guard(const Model *m, const real *x)
{
    real xe[MAX_X], g[MAX_GUARDS];
    double least = 1.0;
    for (int b = 0; b < m->s.n_batches; b++) {
        const Batch *k = &m->s.batches[b];
        for (int i = 0; i < k->n; i++) {
            for (int j = 0; j < k->nxe; j++) xe[j] = x[k->x[i * k->nxe + j]];
            const int n = element_guard(k->kind, xe, k->p + i * k->np, g);
            for (int r = 0; r < n; r++) EACH_LANE if (!(LANE(g[r], w) >= least)) least = LANE(g[r], w);
            if (!n) break;
        }
    }
    return least;
}
