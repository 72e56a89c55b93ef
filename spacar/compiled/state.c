/* Evaluation of a state of the integrators: right-hand side, stages of a step, what frames have besides. */

static const double SMALLEST_PIECE = 1.0 / 64.0; /* of the way to a state that is a jump away */

/* Value, rate and acceleration of a prescribed motion. */
static void prescribed(const Spec *s, const real *row, double t, real *value, real *rate, real *acceleration)
{
    *value = s->polynomial ? row[0] + t * (row[1] + 0.5 * t * row[2]) : row[0];
    *rate = s->polynomial ? row[1] + t * row[2] : row[1];
    *acceleration = row[2];
}

/* Evaluate the state y = (x dynamic, e dynamic, their rates) at t, stresses too when wanted. Number of position iterations,
   or a negative reason; then the last evaluated state is still there. The guess of the position is the Taylor expansion of
   the last state; where transfer functions are known they follow the degrees of freedom, as stages of a step leave the
   parabola. */
static int evaluate(Model *m, State *at, double t, const real *y, double converged, double jump, int want_stress)
{
    const Spec *s = &m->s;
    const int nx = s->nx, first = s->n_fixed_x, n = s->n_position, a = s->n_x_dynamic, q = a + s->n_e_dynamic;
    const real *kinematic = y + q, *rates = kinematic + s->n_x_kinematic + s->n_e_kinematic;
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
    if (at->known == 1 && m->transfer_of == at) {
        const real *d = m->degrees;
        real *off = m->b;
        for (int c = 0; c < q; c++) off[c] = y[c] - (d[c] + dt * (d[q + c] + 0.5 * dt * d[2 * q + c]));
        for (int i = first; i < first + n; i++)
            for (int c = 0; c < q; c++) x[i] += m->transfer[i * m->width + 1 + c] * off[c];
    }
    m->transfer_of = NULL;
    if (!s->polynomial && s->ask(ASK_MOTION, 0, t)) return NOT_ANSWERED;
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
    memcpy(m->near, at->e, sizeof(real) * s->ne);
    for (int i = 0; i < n; i++) m->near[s->position[i]] = at->given_e[s->position[i]];
    const int iterations = place(m, x, xd, m->next_e, m->near, at->given_e, m->given_ed, converged);
    if (iterations < 0) return iterations;
    real moved = EVERY(0.0);
    for (int i = 0; i < nx; i++) moved = lanes_larger(moved, (x[i] - at->x[i]) / s->scale[i]);
    if (!(largest_lane(moved) <= jump)) return JUMP;
    const int status = accelerate(m, t, x, xd, m->next_e, m->given_edd, xdd, at->sigma, want_stress);
    if (status < 0) return status;
    memcpy(at->e, m->next_e, sizeof(real) * s->ne);
    memcpy(at->x, x, sizeof(real) * nx);
    memcpy(at->xd, xd, sizeof(real) * nx);
    memcpy(at->xdd, xdd, sizeof(real) * nx);
    at->t = t;
    at->known = 1;
    if (m->reduced) {
        memcpy(m->degrees, y, sizeof(real) * 2 * q);
        m->transfer_of = at;
    }
    return iterations;
}

/* The same; a state that is a jump away is reached in pieces, so that the mechanism stays on its branch. */
static int spacar_evaluate(Model *m, State *at, double t, const real *y, double converged, double jump, int want_stress)
{
    const Spec *s = &m->s;
    const int a = s->n_x_dynamic, q = a + s->n_e_dynamic, k = q + s->n_x_kinematic, positions = k + s->n_e_kinematic;
    int status = evaluate(m, at, t, y, converged, jump, want_stress);
    for (double part = 0.5; status == JUMP && at->known && part >= SMALLEST_PIECE; part *= 0.5) {
        int reached = OK;
        while (reached >= 0 && status == JUMP) {
            for (int i = 0; i < a; i++) m->piece[i] = at->x[s->x_dynamic + i];
            for (int i = a; i < q; i++) m->piece[i] = at->e[s->e_dynamic + i - a];
            for (int i = q; i < k; i++) m->piece[i] = at->x[s->x_kinematic + i - q];
            for (int i = k; i < positions; i++) m->piece[i] = at->e[s->e_kinematic + i - k];
            for (int i = 0; i < positions; i++) m->piece[i] += part * (y[i] - m->piece[i]);
            memcpy(m->piece + positions, y + positions, sizeof(real) * q);
            reached = evaluate(m, at, at->t + part * (t - at->t), m->piece, converged, jump, 0);
            if (reached >= 0) status = evaluate(m, at, t, y, converged, jump, want_stress);
        }
    }
    return status;
}

static const Sparse *of_rates(const Model *m) { return m->holonomic ? &m->position : &m->velocity; }

/* Logarithm of a number from that of its inverse. */
static double logarithm(double mantissa, double exponent) { return -(log(fabs(mantissa)) + log(2.0) * exponent); }

/* Sign and logarithm of the size of det V[E, U] at the last evaluated state of one case. */
static void position_determinant(const Model *m, double *sign, double *size)
{
    double mantissa[LANES], exponent[LANES];
    determinant(of_rates(m), mantissa, exponent);
    *sign = mantissa[0] < 0.0 ? -1.0 : 1.0;
    *size = logarithm(mantissa[0], exponent[0]);
}

/* Keep the smallest determinant of the evaluated states, and its signs; without logarithms, which cost a part of a small model. */
static void sample(const Model *m, State *at)
{
    double mantissa[LANES], exponent[LANES];
    determinant(of_rates(m), mantissa, exponent);
    const double size = fabs(mantissa[0]);
    at->signs |= mantissa[0] < 0.0 ? 2 : 1;
    if (at->mantissa == 0.0 || exponent[0] > at->exponent || (exponent[0] == at->exponent && size > at->mantissa)) {
        at->mantissa = size;
        at->exponent = exponent[0];
    }
}

static void clear_samples(State *at)
{
    at->signs = 0;
    at->mantissa = at->exponent = 0.0;
}

/* Time derivative of y. */
static int spacar_rhs(Model *m, State *at, double t, const real *y, real *out, double converged, double jump)
{
    const Spec *s = &m->s;
    const int status = spacar_evaluate(m, at, t, y, converged, jump, 0);
    if (status < 0) return status;
    const int a = s->n_x_dynamic, q = a + s->n_e_dynamic, k = q + s->n_x_kinematic, positions = k + s->n_e_kinematic;
    memcpy(out, y + positions, sizeof(real) * q);
    memcpy(out + q, at->xd + s->x_kinematic, sizeof(real) * s->n_x_kinematic);
    for (int i = k; i < positions; i++) out[i] = rate(m, s->e_kinematic + i - k, at->xd);
    memcpy(out + positions, at->xdd + s->x_dynamic, sizeof(real) * a);
    for (int i = a; i < q; i++) {
        const int r = s->e_dynamic + i - a;
        out[positions + i] = rate(m, r, at->xdd) + m->h[r];
    }
    if (LANES == 1 && at->watched) sample(m, at);
    return status;
}

/* Stages `from` ... n - 1 of an explicit Runge-Kutta step from (t, y): K_i = F(t + c_i h, y + h sum_j a_ij K_j), at times not
   outside of [earliest, latest]. Rows of K are `stride` apart. The number of the first stage that could not be
   evaluated, n when all could. */
static int spacar_stages(Model *m, State *at, int from, int n, const double *c, const double *a, double t, double h, double earliest,
                  double latest, const real *y, real *K, int stride, double converged, double jump)
{
    const int size = 2 * (m->s.n_x_dynamic + m->s.n_e_dynamic) + m->s.n_x_kinematic + m->s.n_e_kinematic;
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

/* What frames have besides: rates of all deformations, applied forces, gravity M g and total forces M xdd + h + V^T sigma. */
static void spacar_complete(Model *m, State *at, real *applied, real *gravity, real *total)
{
    const Spec *s = &m->s;
    memcpy(applied, m->applied, sizeof(real) * s->nx);
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
    for (int k = 0; k < m->coupling.n; k++)
        total[m->coupling.row[k]] += m->values[m->coupling.source[k]] * at->xdd[m->coupling.column[k]];
    for (int r = 0; r < s->ne; r++) subtract_transposed(m, r, -at->sigma[r], total);
}
