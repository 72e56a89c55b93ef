/* Evaluation of a state of the integrators: right-hand side, stages of a step, what frames have besides. */

static const double SMALLEST_PIECE = 1.0 / 64.0; /* of the way to a state that is a jump away */
static const double FARTHEST = 20.0;             /* of extrapolation, the product of the times from both states over the square of that between them */

/* Value, rate and acceleration of a prescribed motion. */
static void prescribed(const Spec *s, const real *row, double t, real *value, real *rate, real *acceleration)
{
    *value = s->polynomial ? row[0] + t * (row[1] + 0.5 * t * row[2]) : row[0];
    *rate = s->polynomial ? row[1] + t * row[2] : row[1];
    *acceleration = row[2];
}

/* A coordinate or degree of freedom from those of the last state and of the state before; `c` as in `extrapolation`. */
static inline real ahead_of(const double *c, real x, real v, real a, real x_before, real v_before, real a_before)
{
    return c[0] * (x - x_before) + c[1] * v + c[2] * a + c[3] * v_before + c[4] * a_before;
}

/* The polynomial of fifth degree with position, velocity and acceleration of the last two states, H apart (Hermite), at dt from
   the last one. With u = dt/H it is the parabola through the last state less D (10 u^3 + 15 u^4 + 6 u^5) + E (4 u^3 + 7 u^4 + 3 u^5)
   + F (u^3 + 2 u^4 + u^5)/2, where D, E, F are what the parabola misses of the state before in position, velocity times H and
   acceleration times H^2. */
static void extrapolation(double dt, double H, double *c)
{
    const double u = dt / H, v = u * u * u, D = v * (10.0 + u * (15.0 + 6.0 * u));
    const double E = v * (4.0 + u * (7.0 + 3.0 * u)) * H, F = 0.5 * v * (1.0 + u) * (1.0 + u) * H * H;
    c[0] = D;
    c[1] = dt - D * H + E;
    c[2] = 0.5 * (dt * dt + D * H * H) - E * H + F;
    c[3] = -E;
    c[4] = -F;
}

/* What an extrapolation leaves of the degrees of freedom y, and the largest of it in their sizes. */
static double left_of_degrees(const Spec *s, const Trace *trace, const double *c, const real *y, real *left)
{
    const int a = s->n_x_dynamic, q = a + s->n_e_dynamic;
    const real *d = trace->degrees, *b = d + 3 * q;
    real largest = EVERY(0.0);
    for (int k = 0; k < q; k++) {
        const double size = k < a ? s->scale[s->x_dynamic + k] : s->e_scale[s->e_dynamic + k - a];
        left[k] = y[k] - d[k] - ahead_of(c, d[k], d[q + k], d[2 * q + k], b[k], b[q + k], b[2 * q + k]);
        largest = lanes_larger(largest, left[k] / size);
    }
    return largest_lane(largest);
}

/* A guess of the calculable coordinates of x at dt from the last state. OK, or JUMP when they would go too far.

   It is the parabola through the last state, or the polynomial through the last two where that comes nearer to the degrees of
   freedom, which are known. Where transfer functions are known the guess follows them then, as stages of a step leave
   a smooth motion. */
static int guess(Model *m, const State *at, double dt, const real *y, double jump, real *x)
{
    const Spec *s = &m->s;
    const int first = s->n_fixed_x, end = first + s->n_position, nx = s->nx, q = s->n_x_dynamic + s->n_e_dynamic;
    const Trace *trace = &m->traces[m->traces[0].of != at];
    const int traced = at->known == 1 && trace->of == at && trace->t == at->t;
    const double H = at->t - trace->t_before;
    const real *x0 = trace->before, *v0 = x0 + nx, *a0 = v0 + nx;
    double parabola[] = { 0.0, dt, 0.5 * dt * dt, 0.0, 0.0 }, both[5], *c = parabola;
    real *left = m->b, *left_by_both = left + q, ahead = EVERY(0.0);
    if (traced) {
        const double distance = left_of_degrees(s, trace, parabola, y, left);
        if (fabs(dt * (dt + H)) <= FARTHEST * H * H && H != 0.0) {
            extrapolation(dt, H, both);
            if (left_of_degrees(s, trace, both, y, left_by_both) <= distance) { c = both; left = left_by_both; }
        }
    }
    for (int i = first; i < end; i++) {
        const real move = ahead_of(c, at->x[i], at->xd[i], at->xdd[i], x0[i], v0[i], a0[i]);
        ahead = lanes_larger(ahead, move / s->scale[i]);
        x[i] = at->x[i] + move;
    }
    if (!(largest_lane(ahead) <= 0.5 * jump)) return JUMP; /* as FARTHEST_GUESS of the general path */
    if (traced && m->transfer_of == at)
        for (int i = first; i < end; i++)
            for (int k = 0; k < q; k++) x[i] += m->transfer[i * m->width + 1 + k] * left[k];
    return OK;
}

/* The evaluated state becomes the last one, and that the one before if it has another time. */
static void keep(Model *m, State *at, double t, const real *y, const real *rates)
{
    const Spec *s = &m->s;
    const int nx = s->nx, a = s->n_x_dynamic, q = a + s->n_e_dynamic;
    if (m->traces[0].of != at) {
        const Trace other = m->traces[1];
        m->traces[1] = m->traces[0];
        m->traces[0] = other;
    }
    Trace *trace = m->traces;
    real *d = trace->degrees;
    if (at->known != 1 || trace->of != at || trace->t != at->t) trace->t_before = NAN;
    else if (at->t != t) {
        memcpy(trace->before, at->x, sizeof(real) * nx);
        memcpy(trace->before + nx, at->xd, sizeof(real) * nx);
        memcpy(trace->before + 2 * nx, at->xdd, sizeof(real) * nx);
        memcpy(d + 3 * q, d, sizeof(real) * 3 * q);
        trace->t_before = at->t;
    }
    memcpy(at->e, m->next_e, sizeof(real) * s->ne);
    memcpy(at->x, m->next_x, sizeof(real) * nx);
    memcpy(at->xd, m->next_xd, sizeof(real) * nx);
    memcpy(at->xdd, m->next_xdd, sizeof(real) * nx);
    trace->of = at;
    at->t = trace->t = t;
    at->known = 1;
    memcpy(d, y, sizeof(real) * q);
    memcpy(d + q, rates, sizeof(real) * q);
    for (int i = 0; i < a; i++) d[2 * q + i] = at->xdd[s->x_dynamic + i];
    for (int i = a; i < q; i++) {
        const int r = s->e_dynamic + i - a;
        d[2 * q + i] = rate(m, r, at->xdd) + m->h[r];
    }
    if (m->reduced) m->transfer_of = at;
}

/* Evaluate the state y = (x dynamic, e dynamic, their rates) at t, stresses too when wanted. Number of position iterations,
   or a negative reason; then the last evaluated state is still there. */
static int evaluate(Model *m, State *at, double t, const real *y, double converged, double jump, int want_stress)
{
    const Spec *s = &m->s;
    const int nx = s->nx, n = s->n_position, a = s->n_x_dynamic, q = a + s->n_e_dynamic;
    const real *kinematic = y + q, *rates = kinematic + s->n_x_kinematic + s->n_e_kinematic;
    real *x = m->next_x, *xd = m->next_xd, *xdd = m->next_xdd;
    memcpy(x, s->x0, sizeof(real) * nx);
    memset(xd, 0, sizeof(real) * nx);
    memset(xdd, 0, sizeof(real) * nx);
    if (guess(m, at, at->known ? t - at->t : 0.0, y, jump, x)) return JUMP;
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
    keep(m, at, t, y, rates);
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
    const int q = s->n_x_dynamic + s->n_e_dynamic, k = q + s->n_x_kinematic, positions = k + s->n_e_kinematic;
    memcpy(out, y + positions, sizeof(real) * q);
    memcpy(out + q, at->xd + s->x_kinematic, sizeof(real) * s->n_x_kinematic);
    for (int i = k; i < positions; i++) out[i] = rate(m, s->e_kinematic + i - k, at->xd);
    memcpy(out + positions, m->traces[0].degrees + 2 * q, sizeof(real) * q);
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
