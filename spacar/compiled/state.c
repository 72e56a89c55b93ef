/* Evaluation of a state of the integrators: right-hand side, stages of a step. */

static const double SMALLEST_PIECE = 1.0 / 64.0; /* of the way to a state that is a jump away */
/* at most, by an extrapolation: errors of the positions from which it goes on */
static const double MAGNIFIED = 1e4;

/* The polynomial that has position, velocity and acceleration of n states at the times `at` (Hermite): at t it is
   the sum of c[k][0] x_k + c[k][1] v_k + c[k][2] a_k, one state being a parabola. Each term is G_k(t) = prod_j ((t -
   t_j)/(t_k - t_j))^3, whose two derivatives vanish at the other states, times the first three terms of a series of
   the motion over G_k. The largest c[k][0], by which errors of positions are magnified. */
static double extrapolation(double t, const double *at, int n, double (*c)[3])
{
    double most = 0.0;
    for (int k = 0; k < n; k++) {
        const double s = t - at[k];
        double G = 1.0, sum = 0.0, squares = 0.0;
        for (int j = 0; j < n; j++) {
            if (j == k) continue;
            const double inverse = 1.0 / (at[k] - at[j]);
            G *= (t - at[j]) * inverse;
            sum += inverse;
            squares += inverse * inverse;
        }
        G *= G * G;
        const double first = -3.0 * s * sum, second = 1.5 * s * s * (3.0 * sum * sum + squares);
        c[k][0] = G * (1.0 + first + second);
        c[k][1] = G * s * (1.0 + first);
        c[k][2] = G * 0.5 * s * s;
        most = fmax(most, fabs(c[k][0]));
    }
    return most;
}

/* What the extrapolation from n states leaves of the degrees of freedom y, and the largest of it in their sizes. */
static double left_of_degrees(const Spec *s, const Trace *trace, const double (*c)[3], int n, const real *y, real *left)
{
    const int a = s->n_x_dynamic, q = a + s->n_e_dynamic;
    real largest = EVERY(0.0);
    for (int i = 0; i < q; i++) {
        const double size = i < a ? s->scale[s->x_dynamic + i] : s->e_scale[s->e_dynamic + i - a];
        const real last = trace->degrees[0][i];
        left[i] = y[i] - last;
        for (int k = 0; k < n; k++) {
            const real *d = trace->degrees[k];
            left[i] -= c[k][0] * (d[i] - last) + c[k][1] * d[q + i] + c[k][2] * d[2 * q + i];
        }
        largest = lanes_larger(largest, left[i] / size);
    }
    return largest_lane(largest);
}

/* Is x, in the sizes of its coordinates, no farther than `far` from the last state? A common translation of nodes that
   are joined, which deforms no element, is no distance: along each axis what they go the same way. As `_jump` of
   kinematics.py. */
static int is_near(Model *m, const State *at, const real *x, double far)
{
    const Spec *s = &m->s;
    real *low = m->b, *high = low + s->nx;
    for (int k = 0; k < s->nx; k++) { low[k] = EVERY(DBL_MAX); high[k] = EVERY(-DBL_MAX); }
    for (int i = 0; i < s->nx; i++) {
        const real moved = (x[i] - at->x[i]) / s->scale[i];
        const int k = s->translation[i];
        EACH_LANE {
            const double d = LANE(moved, w);
            if (k < 0 && !(fabs(d) <= far)) return 0;
            if (k >= 0) { LANE(low[k], w) = fmin(LANE(low[k], w), d); LANE(high[k], w) = fmax(LANE(high[k], w), d); }
        }
    }
    for (int k = 0; k < s->nx; k++)
        EACH_LANE {
            const double least = LANE(low[k], w), most = LANE(high[k], w);
            if (least <= most && !(most - fmax(least, 0.0) <= far && fmin(most, 0.0) - least <= far)) return 0;
        }
    return 1;
}

/* A guess of the calculable coordinates of x at t. OK, or JUMP when they go far.

   It goes on from as many states as come near to the degrees of freedom, which are known: from one more unless that
   comes twice as far. Where transfer functions are known the guess follows the degrees of freedom then, as stages of
   a step leave a smooth motion. */
static int guess(Model *m, const State *at, double t, const real *y, double far, real *x)
{
    const Spec *s = &m->s;
    const int first = s->n_fixed_x, end = first + s->n_position, nx = s->nx, q = s->n_x_dynamic + s->n_e_dynamic;
    const Trace *trace = &m->traces[m->traces[0].of != at];
    const int traced = at->known == 1 && trace->of == at && trace->t[0] == at->t;
    double coefficients[2][STATES][3], (*c)[3] = coefficients[0], (*more)[3] = coefficients[1];
    real *left = m->b, *left_by_more = left + q, ahead = EVERY(0.0);
    int n = 1;
    extrapolation(at->known ? t : at->t, &at->t, 1, c);
    if (traced) {
        double distance = left_of_degrees(s, trace, c, 1, y, left);
        for (int k = 2; k <= trace->n && extrapolation(t, trace->t, k, more) <= MAGNIFIED; k++) {
            const double by_more = left_of_degrees(s, trace, more, k, y, left_by_more);
            if (!(by_more <= 2.0 * distance)) break;
            distance = fmin(distance, by_more);
            n = k;
            double (*of_less)[3] = c;
            real *left_by_less = left;
            c = more; more = of_less;
            left = left_by_more; left_by_more = left_by_less;
        }
    }
    for (int i = first; i < end; i++) x[i] = c[0][1] * at->xd[i] + c[0][2] * at->xdd[i];
    for (int k = 1; k < n; k++) {
        const real *x0 = trace->before[k - 1], *v0 = x0 + nx, *a0 = v0 + nx;
        for (int i = first; i < end; i++) x[i] += c[k][0] * (x0[i] - at->x[i]) + c[k][1] * v0[i] + c[k][2] * a0[i];
    }
    for (int i = first; i < end; i++) {
        ahead = lanes_larger(ahead, x[i] / s->scale[i]);
        x[i] += at->x[i];
    }
    if (traced && m->transfer_of == at)
        for (int i = first; i < end; i++)
            for (int k = 0; k < q; k++) x[i] += m->transfer[i * m->width + 1 + k] * left[k];
    return largest_lane(ahead) <= far ? OK : JUMP;
}

/* The evaluated state becomes the last one, and what was that is remembered if it has another time. */
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
    if (at->known != 1 || trace->of != at || trace->t[0] != at->t) trace->n = 1;
    else if (at->t != t) {
        real *before = trace->before[STATES - 2], *degrees = trace->degrees[STATES - 1];
        for (int k = STATES - 1; k > 0; k--) {
            trace->t[k] = trace->t[k - 1];
            trace->degrees[k] = trace->degrees[k - 1];
            if (k > 1) trace->before[k - 1] = trace->before[k - 2];
        }
        trace->degrees[0] = degrees;
        trace->before[0] = before;
        memcpy(before, at->x, sizeof(real) * 3 * nx);
        if (trace->n < STATES) trace->n++;
    }
    memcpy(at->e, m->next_e, sizeof(real) * s->ne);
    memcpy(at->x, m->next_x, sizeof(real) * 3 * nx);
    trace->of = at;
    at->t = trace->t[0] = t;
    at->known = 1;
    real *d = trace->degrees[0];
    memcpy(d, y, sizeof(real) * q);
    memcpy(d + q, rates, sizeof(real) * q);
    for (int i = 0; i < a; i++) d[2 * q + i] = at->xdd[s->x_dynamic + i];
    for (int i = a; i < q; i++) {
        const int r = s->e_dynamic + i - a;
        d[2 * q + i] = rate(m, r, at->xdd) + m->h[r];
    }
    if (m->reduced) m->transfer_of = at;
}

/* After a stage of an explicit Runge-Kutta step: it does not lie on a smooth motion, from which a guess could go on. */
static void leave_motion(Model *m) { m->traces[0].n = 0; }

/* Evaluate the state y = (x dynamic, e dynamic, their rates) at t, stresses too when wanted. Number of position
   iterations, or a negative reason; then the last evaluated state is still there. */
static int evaluate(Model *m, State *at, double t, const real *y, double converged, double jump, int want_stress)
{
    const Spec *s = &m->s;
    const int nx = s->nx, n = s->n_position, q = s->n_x_dynamic + s->n_e_dynamic;
    real *x = m->next_x, *xd = m->next_xd, *xdd = m->next_xdd;
    const double farthest = 0.5 * jump; /* as FARTHEST_GUESS of the general path */
    const int far = !m->tree && guess(m, at, t, y, farthest, x);
    if (take_given(m, at, t, y, x, xd, xdd)) return NOT_ANSWERED;
    if (far && !is_near(m, at, x, farthest)) return JUMP;
    m->transfer_of = NULL;
    m->of_tree = m->matrices_behind = m->factors_behind = 0;
    if (m->tree) {
        follow_tree(s, m->tree, x, xd, xdd, at->given_e, m->given_ed, m->given_edd);
        memset(xd + s->n_fixed_x, 0, sizeof(real) * n);
    }
    follow(m, at->x, at->e, m->branch);
    const int iterations = place(m, x, xd, m->next_e, m->branch, at->given_e, m->given_ed, converged);
    if (iterations < 0) return iterations;
    real moved = EVERY(0.0);
    for (int i = 0; i < nx; i++) moved = lanes_larger(moved, (x[i] - at->x[i]) / s->scale[i]);
    /* a tree has no other branches */
    if (!m->tree && !(largest_lane(moved) <= jump) && !is_near(m, at, x, jump)) return JUMP;
    const int status = accelerate(m, t, x, xd, m->next_e, m->given_edd, xdd, at->sigma, want_stress);
    if (status < 0) return status;
    keep(m, at, t, y, y + q + s->n_x_kinematic + s->n_e_kinematic);
    return iterations;
}

/* The same; a state that is a jump away is reached in pieces, so that the mechanism stays on its branch. */
static int evaluate_in_pieces(Model *m, State *at, double t, const real *y, double converged, double jump,
    int want_stress)
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

/* Keep the smallest determinant of the evaluated states, and its signs; without logarithms, which cost a part of a
   small model. */
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

/* Time derivative of y, from the equations of all elements. */
static int rates_of_elements(Model *m, State *at, double t, const real *y, real *out, double converged, double jump)
{
    const Spec *s = &m->s;
    const int status = evaluate_in_pieces(m, at, t, y, converged, jump, 0);
    if (status < 0) return status;
    const int q = s->n_x_dynamic + s->n_e_dynamic, k = q + s->n_x_kinematic, positions = k + s->n_e_kinematic;
    memcpy(out, y + positions, sizeof(real) * q);
    memcpy(out + q, at->xd + s->x_kinematic, sizeof(real) * s->n_x_kinematic);
    for (int i = k; i < positions; i++) out[i] = rate(m, s->e_kinematic + i - k, at->xd);
    memcpy(out + positions, m->traces[0].degrees[0] + 2 * q, sizeof(real) * q);
    if (LANES == 1 && at->watched) sample(m, at);
    return status;
}

static int n_of_state(const Spec *s)
{
    return 2 * (s->n_x_dynamic + s->n_e_dynamic) + s->n_x_kinematic + s->n_e_kinematic;
}

/* Whether the state holds everything of y at t, and nothing has been evaluated since. A user function is asked
   again: it may count. */
static int is_evaluated(const Model *m, const State *at, double t, const real *y)
{
    return !m->s.user && at->whole && at->whole == m->evaluations && at->t == t
        && !memcmp(at->y, y, sizeof(real) * n_of_state(&m->s));
}

/* Time derivative of the y that the state holds everything of. */
static void rates_of_whole(const Model *m, const State *at, real *out)
{
    const Spec *s = &m->s;
    const int a = s->n_x_dynamic, b = s->n_e_dynamic, k = s->n_x_kinematic, l = s->n_e_kinematic;
    memcpy(out, at->y + a + b + k + l, sizeof(real) * (a + b));
    memcpy(out += a + b, at->xd + s->x_kinematic, sizeof(real) * k);
    memcpy(out += k, at->ed + s->e_kinematic, sizeof(real) * l);
    memcpy(out += l, at->xdd + s->x_dynamic, sizeof(real) * a);
    memcpy(out + a, at->edd + s->e_dynamic, sizeof(real) * b);
}

/* Time derivative of y. */
static int spacar_rhs(Model *m, State *at, double t, const real *y, real *out, double converged, double jump)
{
    if (is_evaluated(m, at, t, y)) {
        rates_of_whole(m, at, out);
        if (LANES == 1 && at->watched && !m->tree) sample(m, at);
        return OK;
    }
    return m->tree ? tree_rates(m, at, t, y, out) : rates_of_elements(m, at, t, y, out, converged, jump);
}

/* sum_j w_j K_j over the first `count` rows, `stride` apart, into out (n). */
static void combine(const double *K, int stride, const double *w, int count, int n, double *out)
{
    for (int i = 0; i < n; i++) out[i] = 0.0;
    for (int j = 0; j < count; j++)
        if (w[j] != 0.0)
            for (int i = 0; i < n; i++) out[i] += w[j] * K[j * stride + i];
}

/* y + h times the same. */
static void advance(const double *y, double h, const double *K, int stride, const double *w, int count, int n,
    double *out)
{
    combine(K, stride, w, count, n, out);
    for (int i = 0; i < n; i++) out[i] = y[i] + h * out[i];
}

/* Stages `from` ... n - 1 of an explicit Runge-Kutta step from (t, y): K_i = F(t + c_i h, y + h sum_j a_ij K_j), at
   times not outside of [earliest, latest]. Rows of K are `stride` apart. The number of the first stage that could
   not be evaluated, n when all could. */
static int spacar_stages(Model *m, State *at, int from, int n, const double *c, const double *a, double t, double h,
    double earliest, double latest, const real *y, real *K, int stride, double converged, double jump)
{
    const int size = n_of_state(&m->s) * LANES;
    real *stage = m->stage;
    for (int i = from; i < n; i++) {
        advance((const double *)y, h, (const double *)K, stride * LANES, a + i * n, i, size, (double *)stage);
        const double time = fmin(fmax(t + c[i] * h, earliest), latest);
        if (spacar_rhs(m, at, time, stage, K + i * stride, converged, jump) < 0) return i;
        leave_motion(m);
    }
    return n;
}
