/* Position, velocity and acceleration of a holonomic mechanism (theory-system.md (1), (2), (9)).

   The accelerations come from the saddle-point form, or with few degrees of freedom from the reduced form, whose
   transfer functions need nothing but solutions with the matrix of the position; stresses are computed where
   somebody looks. */

/* How well the scaled residual is known at x, lane by lane: `Kinematics.rounding` of the general path. */
static real rounding(const Model *m, const real *x, const real *e_given)
{
    real size = EVERY(1.0);
    for (int i = 0; i < m->s.nx; i++) size = lanes_larger(size, x[i] / m->s.scale[i]);
    for (int i = 0; i < m->s.n_position; i++)
        size = lanes_larger(size, e_given[m->s.position[i]] / m->s.e_scale[m->s.position[i]]);
    return m->s.criteria->rounding * size;
}

/* Complete a velocity or acceleration v, which comes with the given components and zeros: V v = e_rate - h. */
static void dependent(Model *m, real *v, const real *e_rate, const real *h)
{
    const Spec *s = &m->s;
    const int n = s->n_equations, nc = s->n_position, first = s->n_fixed_x;
    real *r = m->b;
    for (int i = 0; i < n; i++) r[i] = h ? e_rate[i] - h[i] : e_rate[i];
    if (s->n_x_input || s->n_x_dynamic) for (int i = 0; i < n; i++) r[i] -= rate(m, i, v);
    if (m->holonomic) { solve(&m->position, r, v + first); return; }
    solve(&m->velocity, r, r);
    memcpy(v + first, r, sizeof(real) * nc);
    memcpy(v + s->x_kinematic, r + nc, sizeof(real) * s->n_x_kinematic);
}

/* How many of Newton's corrections an error takes until the last one is below `converged`: each leaves the square. */
static int corrections(const Model *m, double error, double converged)
{
    int n = 1;
    for (; error > converged && n < m->s.max_iterations; n++) error *= error;
    return n;
}

/* Whether a correction with the factors of another position saves one with new factors. It leaves of an error as
   much as the gradient has changed, about the distance of the positions in their sizes. Only time depends on it. */
static int takes_old_factors(const Model *m, const real *x, double error, double converged)
{
    const int first = m->s.n_fixed_x, end = first + m->s.n_position;
    real moved = EVERY(0.0);
    for (int i = first; i < end; i++) moved = lanes_larger(moved, (x[i] - m->factored_x[i]) / m->s.scale[i]);
    return corrections(m, largest_lane(moved) * error, converged) < corrections(m, error, converged);
}

/* Position and velocity. x comes with the given values and a guess of the calculable ones, xd and ed with the given
   rates. The first correction uses the matrix of the last state, which is still factored, where that saves
   something. A correction that follows one below the limit or rounding is as small as rounding allows and passes
   always. A residual that stays at rounding with larger corrections is left to the general path, which looks at the
   condition. */
static int place(Model *m, real *x, real *xd, real *e, const real *branch, const real *e_given, const real *e_rate,
                 double converged)
{
    const int n = m->s.n_position, first = m->s.n_fixed_x, *row = m->s.position;
    real *r = m->b;
    double limit = m->s.criteria->converged, before = INFINITY, last = INFINITY;
    real before_step = EVERY(INFINITY);
    int halvings = 0;
    for (int iteration = 1; iteration <= m->s.max_iterations; iteration++) {
        if (strain(m, x, branch, e)) return NOT_ANSWERED;
        real residual = EVERY(0.0), total = EVERY(0.0);
        for (int i = 0; i < n; i++) {
            const real difference = e[row[i]] - e_given[row[i]];
            residual = lanes_larger(residual, difference / m->s.e_scale[row[i]]);
            total += difference;
        }
        const double norm = largest_lane(residual);
        if (!isfinite(norm) || !isfinite(largest_lane(total))) return NOT_FINITE;
        const int grows = norm > 2.0 * before && norm > m->s.criteria->grown;
        if (grows && largest_lane(residual - rounding(m, x, e_given)) > 0.0) {
            if (++halvings > 5) return NO_CONVERGENCE;
            for (int i = 0; i < n; i++) { r[i] *= 0.5; x[first + i] += r[i]; }
            continue;
        }
        before = norm;
        halvings = 0;
        for (int i = 0; i < n; i++) r[i] = e[row[i]] - e_given[row[i]];
        const int chord = iteration == 1 && m->factored && takes_old_factors(m, x, norm, converged);
        if (!chord) {
            const int status = factor(&m->position, m->values);
            m->factored = !status;
            if (status) return status;
            memcpy(m->factored_x, x, sizeof(real) * m->s.nx);
        }
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
        if (largest > converged && last > limit && !(largest_lane(before_step - rounding(m, x, e_given)) <= 0.0)) {
            last = largest;
            before_step = step;
            continue;
        }
        if (!m->holonomic) {
            const int of_velocity = factor(&m->velocity, m->values);
            if (of_velocity) return of_velocity;
        }
        dependent(m, xd, e_rate, NULL);
        return iteration;
    }
    return NO_CONVERGENCE;
}

/* Constitutive stresses, and the applied forces but gravity on moving elements. ed: NULL where they are V xd. OK or
   NOT_ANSWERED. */
static int stresses(const Model *m, double t, const real *x, const real *e, const real *xd, const real *ed, real *sigma)
{
    const Spec *s = &m->s;
    memcpy(m->applied, s->force, sizeof(real) * s->nx);
    for (int k = 0; k < s->n_moments; k++) m->applied[s->moment_rows[k]] += s->moments[k] * x[s->moment_columns[k]];
    memcpy(sigma, s->preload, sizeof(real) * s->ne);
    for (int i = 0; i < s->n_stiffness; i++) sigma[s->s_rows[i]] += s->s_values[i] * e[s->s_columns[i]];
    for (int i = 0; i < s->n_damping; i++)
        sigma[s->d_rows[i]] += s->d_values[i] * (ed ? ed[s->d_columns[i]] : rate(m, s->d_columns[i], xd));
    const User *user = s->user;
    if (!user) return OK;
    memcpy(user->x, x, sizeof(real) * s->nx);
    memcpy(user->xd, xd, sizeof(real) * s->nx);
    memcpy(user->e, e, sizeof(real) * s->ne);
    for (int r = 0; r < s->ne; r++) user->ed[r] = ed ? ed[r] : rate(m, r, xd);
    memset(user->force, 0, sizeof(real) * s->nx);
    memset(user->sigma, 0, sizeof(real) * s->ne);
    if (ask_stresses(s->asking, t)) return NOT_ANSWERED;
    for (int i = 0; i < s->nx; i++) m->applied[i] += user->force[i];
    for (int r = s->n_rows; r < s->ne; r++) sigma[r] += user->sigma[r];
    return OK;
}

/* f + M g - h - M xdd_given - V^T sigma of the rows from first_row, at every coordinate. */
static void out_of_balance(const Model *m, const real *xdd, const real *sigma, int first_row, real *out)
{
    const Spec *s = &m->s;
    /* without degrees of freedom all accelerations are known */
    const Entries *given = s->prescribed ? &m->mass : &m->given;
    for (int i = 0; i < s->nx; i++) out[i] = m->applied[i] - m->convected[i];
    for (int k = 0; k < given->n; k++) {
        const int j = given->column[k];
        out[given->row[k]] += m->values[given->source[k]] * (s->field[j] - xdd[j]);
    }
    for (int k = 0; k < m->coupling.n; k++)
        out[m->coupling.row[k]] -= m->values[m->coupling.source[k]] * xdd[m->coupling.column[k]];
    for (int r = first_row; r < s->ne; r++) subtract_transposed(m, r, sigma[r], out);
}

/* Solve A b = -r with a positive definite A, as L^T D L from the last row up, which a tree whose degrees of freedom
   are counted from the ground outwards does not fill (Featherstone, "Efficient factorization of the joint-space
   inertia matrix for branched kinematic trees", 2005). Rows `width` apart hold r, then the lower triangle of A.
   SINGULAR when a pivot is lost in rounding: 45 eps of the diagonal from which it is the difference. That accepts
   and refuses nothing; it hands the state to the saddle-point form of the general path, which does not form these
   differences. */
static int solve_positive(real *A, int width, int n, real *diagonal, real *b)
{
    for (int k = 0; k < n; k++) diagonal[k] = A[k * width + 1 + k];
    for (int k = n - 1; k >= 0; k--) {
        real *row = A + k * width;
        EACH_LANE if (!(LANE(row[1 + k], w) > 1e-14 * LANE(diagonal[k], w))) return SINGULAR;
        const real inverse = 1.0 / row[1 + k];
        for (int i = 0; i < k; i++) {
            if (LANES == 1 && LANE(row[1 + i], 0) == 0.0) continue;
            add_row(A + i * width, -inverse * row[1 + i], row, (1 + i + ROW) / ROW * ROW);
        }
    }
    for (int k = 0; k < n; k++) {
        const real *row = A + k * width;
        real sum = -row[0];
        for (int j = 0; j < k; j++) sum -= row[1 + j] * b[j];
        b[k] = sum / row[1 + k];
    }
    return OK;
}

/* `parts` columns of ROW numbers of the rows of M X from `first` on, into out; X and out (nx, width), both from that
   column on. `parts` is a constant here and below, so that the sums stay in registers. */
static inline __attribute__((always_inline)) void mass_times(const Model *m, int first, const real *X, int width,
    real *out, const int parts)
{
    for (int i = first; i < m->s.nx; i++) {
        row_part sum[parts], *to = (row_part *)(out + i * width);
        for (int p = 0; p < parts; p++) sum[p] = (row_part){0};
        for (int k = m->m_start[i]; k < m->m_start[i + 1]; k++) {
            const real value = m->values[m->m_place[k]];
            const row_part *from = (const row_part *)(X + m->m_column[k] * width);
            for (int p = 0; p < parts; p++) sum[p] += value * from[p];
        }
        for (int p = 0; p < parts; p++) to[p] = sum[p];
    }
}

/* The same of one row of X^T MX: of the column x, whose numbers are `width` apart; n rows. */
static inline __attribute__((always_inline)) void projected(const real *x, const real *MX, int width, int n, real *out,
                                                            const int parts)
{
    row_part sum[parts], *to = (row_part *)out;
    for (int p = 0; p < parts; p++) sum[p] = (row_part){0};
    for (int i = 0; i < n; i++) {
        const real factor = x[i * width];
        if (LANES == 1 && LANE(factor, 0) == 0.0) continue;
        const row_part *from = (const row_part *)(MX + i * width);
        for (int p = 0; p < parts; p++) sum[p] += factor * from[p];
    }
    for (int p = 0; p < parts; p++) to[p] = sum[p];
}

/* The lower half of X^T MX: rows of A, one for each of the q columns behind the first; n rows of X. */
static void project(const real *X, const real *MX, int width, int n, int q, real *A)
{
    for (int c = 0; c < q; c++) {
        const real *x = X + 1 + c;
        const int end = (1 + c + ROW) / ROW * ROW;
        real *to = A + c * width;
        int column = 0;
        for (; column + 4 * ROW <= end; column += 4 * ROW) projected(x, MX + column, width, n, to + column, 4);
        for (; column + 2 * ROW <= end; column += 2 * ROW) projected(x, MX + column, width, n, to + column, 2);
        for (; column < end; column += ROW) projected(x, MX + column, width, n, to + column, 1);
    }
}

/* Reduced form: columns of `transfer` (nx, width) are the acceleration without the degrees of freedom, less gravity,
   and the transfer functions of these q; zeros fill up the rows. `weighted` is M times them, without the rows of
   what is fixed, with the forces subtracted from its first column. xdd and, when wanted, sigma are completed from
   the given ones. */
static int reduced_form(Model *m, const real *edd_given, real *xdd, real *sigma, int want_stress)
{
    const Spec *s = &m->s;
    const int nx = s->nx, n = s->n_equations, first = s->n_fixed_x, a = s->n_x_dynamic, q = a + s->n_e_dynamic,
        width = m->width;
    real *X = m->transfer, *MX = m->weighted, *A = m->small;
    real *right = X + first * width;
    memset(X, 0, sizeof(real) * nx * width);
    for (int k = 0; k < m->dynamic.n; k++)
        right[m->dynamic.row[k] * width + 1 + m->dynamic.column[k]] -= m->values[m->dynamic.source[k]];
    for (int c = a; c < q; c++) right[(s->e_dynamic + c - a) * width + 1 + c] = EVERY(1.0);
    for (int i = 0; i < n; i++) right[i * width] = edd_given[i] - m->h[i];
    if (s->n_x_input) for (int i = 0; i < n; i++) right[i * width] -= rate(m, i, xdd);
    solve_rows(&m->position, right, width);
    for (int c = 0; c < a; c++) X[(s->x_dynamic + c) * width + 1 + c] = EVERY(1.0);
    for (int i = 0; i < n; i++) xdd[first + i] = X[(first + i) * width];
    for (int i = 0; i < nx; i++) X[i * width] = xdd[i] - s->field[i];
    int column = 0;
    for (; column + 4 * ROW <= width; column += 4 * ROW) mass_times(m, first, X + column, width, MX + column, 4);
    for (; column + 2 * ROW <= width; column += 2 * ROW) mass_times(m, first, X + column, width, MX + column, 2);
    for (; column < width; column += ROW) mass_times(m, first, X + column, width, MX + column, 1);
    for (int k = 0; k < m->coupling.n; k++) { /* gravity does not act on it */
        const real value = m->values[m->coupling.source[k]];
        const int i = m->coupling.row[k], j = m->coupling.column[k];
        if (i < first) continue;
        add_row(MX + i * width, value, X + j * width, width);
        MX[i * width] += value * s->field[j];
    }
    real *force = m->force;
    for (int i = 0; i < nx; i++) force[i] = m->applied[i] - m->convected[i];
    for (int r = s->n_rows; r < s->ne; r++) subtract_transposed(m, r, sigma[r], force);
    for (int i = first; i < nx; i++) MX[i * width] -= force[i];
    project(X + first * width, MX + first * width, width, nx - first, q, A);
    real *b = m->b + q;
    if (solve_positive(A, width, q, m->b, b)) return SINGULAR;
    for (int i = first; i < nx; i++)
        for (int c = 0; c < q; c++) xdd[i] += X[i * width + 1 + c] * b[c];
    real sum = EVERY(0.0);
    for (int i = first; i < nx; i++) sum += xdd[i];
    if (!isfinite(largest_lane(sum))) return NOT_FINITE;
    if (!want_stress) return OK;
    for (int i = first; i < first + n; i++) {
        force[i] = -MX[i * width];
        for (int c = 0; c < q; c++) force[i] -= MX[i * width + 1 + c] * b[c];
    }
    solve_transposed(&m->position, force + first, m->b);
    memcpy(sigma, m->b, sizeof(real) * s->n_rows);
    return OK;
}

/* xdd comes with the given accelerations (zero elsewhere); it is completed, and so is sigma when wanted. The
   position system must be factored. */
static int accelerate(Model *m, double t, const real *x, const real *xd, const real *e, const real *edd_given,
    real *xdd, real *sigma, int want_stress)
{
    const Spec *s = &m->s;
    const int n = s->n_equations, nf = s->n_free, nr = s->n_rows;
    if (inertia(m, x, xd, 1) || stresses(m, t, x, e, xd, NULL, sigma)) return NOT_ANSWERED;
    real *b = m->b, sum = EVERY(0.0);
    if (s->prescribed) { /* no dynamic degree of freedom: kinematics, then reactions from the transposed system */
        const int nc = s->n_position;
        dependent(m, xdd, edd_given, m->h);
        out_of_balance(m, xdd, sigma, n, m->force);
        memcpy(b, m->force + s->n_fixed_x, sizeof(real) * nc);
        if (!m->holonomic) memcpy(b + nc, m->force + s->x_kinematic, sizeof(real) * s->n_x_kinematic);
        solve_transposed(m->holonomic ? &m->position : &m->velocity, b, sigma);
        for (int i = 0; i < n; i++) sum += sigma[i];
        for (int i = s->n_fixed_x; i < s->nx; i++) sum += xdd[i];
        return isfinite(largest_lane(sum)) ? OK : NOT_FINITE;
    }
    if (m->reduced) return reduced_form(m, edd_given, xdd, sigma, want_stress);
    out_of_balance(m, xdd, sigma, nr, m->force);
    for (int i = 0; i < nf; i++) b[i] = m->force[s->free[i]];
    for (int r = 0; r < nr; r++) b[nf + r] = edd_given[r] - m->h[r];
    if (s->n_x_input) for (int r = 0; r < nr; r++) b[nf + r] -= rate(m, r, xdd);
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

/* What is given of x, xd and xdd at t, and of e and its rates; the rest of x stays, that of xd and xdd is zero. OK
   or NOT_ANSWERED. */
static int take_given(Model *m, State *at, double t, const real *y, real *x, real *xd, real *xdd)
{
    const Spec *s = &m->s;
    const int nx = s->nx, a = s->n_x_dynamic, q = a + s->n_e_dynamic;
    const real *kinematic = y + q, *rates = kinematic + s->n_x_kinematic + s->n_e_kinematic;
    m->evaluations++;
    memcpy(x, s->x0, sizeof(real) * s->n_fixed_x);
    memset(xd, 0, sizeof(real) * nx);
    memset(xdd, 0, sizeof(real) * nx);
    if (!s->polynomial && ask(s->asking, ASK_MOTION, 0, t)) return NOT_ANSWERED;
    for (int i = 0; i < s->n_x_input; i++) {
        const int k = s->x_input + i;
        prescribed(s, s->x_motion + 3 * i, t, &x[k], &xd[k], &xdd[k]);
    }
    for (int i = 0; i < s->n_e_input; i++) {
        const int k = s->e_input + i;
        prescribed(s, s->e_motion + 3 * i, t, &at->given_e[k], &m->given_ed[k], &m->given_edd[k]);
    }
    for (int i = 0; i < a; i++) { x[s->x_dynamic + i] = y[i]; xd[s->x_dynamic + i] = rates[i]; }
    for (int i = a; i < q; i++) {
        at->given_e[s->e_dynamic + i - a] = y[i];
        m->given_ed[s->e_dynamic + i - a] = rates[i];
    }
    memcpy(x + s->x_kinematic, kinematic, sizeof(real) * s->n_x_kinematic);
    memcpy(at->given_e + s->e_kinematic, kinematic + s->n_x_kinematic, sizeof(real) * s->n_e_kinematic);
    return OK;
}
