/* Steps of an integrator in one call, up to the next output (`spacar.compiled.compiled_stepper`), with the arrays and
   coefficients of spacar/integrators. Python is asked for derivatives that the model in C cannot give, and told of
   accepted steps at which the watch of dead points (spacar/forward/continuity.py) has to look closer.

   Several cases share their steps: n, and every array of the state, counts all lanes, a step has the largest error
   of a case, and where one of them would have to be asked or told about, the call ends: Python follows them alone. */

static double *record(const Stepper *r, int k) { return r->records + (size_t)(k % r->capacity) * r->width; }

/* F at a time inside the window: 0, 1, 2 as AskRate. */
static int derivative(Stepper *r, double t, const double *y, double *f)
{
    t = fmin(fmax(t, r->earliest), r->latest);
    if (spacar_rhs(r->model, r->at, t, (const real *)y, (real *)f, r->converged, r->jump) >= 0) {
        double sum = 0.0;
        for (int i = 0; i < r->n; i++) sum += f[i];
        if (isfinite(sum)) { r->n_rhs++; return 0; }
    }
    return r->ask ? r->ask(t, y, f) : 1;
}

static inline real size_of(real a) { return lanes_larger(EVERY(0.0), a); }

/* `unexplained` of spacar/dynamics/loaded_mechanism.py, of any coordinate of a case. */
static int unexplained(const Stepper *r, const double *a, const double *b)
{
    const int nx = r->model->s.nx;
    const double h = b[0] - a[0];
    const real *va = (const real *)(a + 4 + r->n) + nx, *vb = (const real *)(b + 4 + r->n) + nx, *aa = va + nx,
        *ab = vb + nx;
    real fastest = EVERY(0.0), most = EVERY(0.0);
    for (int i = 0; i < nx; i++) fastest = lanes_larger(fastest, lanes_larger(size_of(va[i]), vb[i]) / r->scale[i]);
    /* of a case that stands, all is explained */
    EACH_LANE if (!(LANE(fastest, w) * fabs(h) > r->still)) LANE(fastest, w) = INFINITY;
    for (int i = 0; i < nx; i++) {
        const real v = lanes_larger(size_of(va[i]), vb[i]), acceleration = lanes_larger(size_of(aa[i]), ab[i]);
        const real change = size_of(vb[i] - va[i] - 0.5 * h * (aa[i] + ab[i]));
        const real beyond = change - (fabs(h) * acceleration + r->share * v + fastest * (r->scale[i] * r->noise));
        /* zero where it is negative; what is not a number counts as none */
        most = lanes_larger(most, beyond + size_of(beyond));
    }
    return largest_lane(most) > 0.0;
}

/* Does a coordinate go farther in the step than the watch sees with the states inside alone? */
static int goes_far(const Stepper *r, const double *a, const double *b)
{
    const int nx = r->model->s.nx;
    const double *va = a + 4 + r->n + nx, *vb = b + 4 + r->n + nx;
    double fastest = 0.0;
    for (int i = 0; i < nx; i++) fastest = fmax(fastest, fmax(fabs(va[i]), fabs(vb[i])) / r->scale[i]);
    return (b[0] - a[0]) * fastest > r->far;
}

#if LANES > 1
/* Does one of the cases come to a dead point or half a turn, or do its velocities jump? */
static int has_to_be_alone(Stepper *r, const double *before, const double *now)
{
    int alone = !r->at->known;
    for (int i = 0; i < r->n_lambda0; i++) EACH_LANE alone |= fabs(LANE(r->at->x[r->lambda0[i]], w)) < r->half_turn;
    if (r->model->tree) return alone; /* it has no dead points */
    double mantissa[LANES], exponent[LANES];
    determinant(of_rates(r->model), mantissa, exponent);
    EACH_LANE {
        const double sign = mantissa[w] < 0.0 ? -1.0 : 1.0;
        alone |= before && sign != r->signs[w];
        r->signs[w] = sign;
    }
    return alone || (before && unexplained(r, before, now));
}
#endif

/* Record the step that the state stands at. */
static double *recorded(Stepper *r, const double *y)
{
    const State *s = r->at;
    const int nx = r->model->s.nx * LANES;
    double *now = record(r, r->recorded++);
    now[0] = s->t;
    now[1] = 1.0;
    now[2] = 0.0;
    now[3] = s->known;
    memcpy(now + 4, y, sizeof(double) * r->n);
    double *x = now + 4 + r->n;
    memcpy(x, s->x, sizeof(double) * 3 * nx);
    memcpy(x + 3 * nx, s->e, sizeof(real) * r->model->s.ne);
    return now;
}

/* Record the start of a motion where it stands; Python does where it remembers the steps itself, or knows the state
   alone. */
static void started(Stepper *r, const double *y)
{
    if (LANES > 1 || r->recorded || r->look == LOOK_ALWAYS || !r->at->known) return;
    double *now = recorded(r, y);
    if (r->look == LOOK_AT_DETERMINANTS && !r->model->tree) {
        position_determinant(r->model, &now[1], &now[2]);
        r->peak = now[2];
    }
    clear_samples(r->at);
}

/* Record the accepted step that the state stands at, and tell of it if it has to be looked at; 0, or 2 when all has
   to end. */
static int seen(Stepper *r, double t, const double *y)
{
    const Model *m = r->model;
    const State *s = r->at;
    r->n_steps++;
    if (r->recorded && !(s->t > record(r, r->recorded - 1)[0])) r->recorded = 0;
    const double *before = r->recorded ? record(r, r->recorded - 1) : NULL;
    double *now = recorded(r, y);
#if LANES > 1
    return has_to_be_alone(r, before, now) ? 2 : 0;
#else
    if (!s->known) return r->ask(t, y, NULL);
    if (m->tree) return 0; /* it has no dead points */
    if (r->look == LOOK_AT_DETERMINANTS) {
        const double low = logarithm(s->mantissa, s->exponent);
        position_determinant(m, &now[1], &now[2]);
        if (r->entered) return r->ask(t, y, NULL);
        if (!before) r->peak = now[2];
        else if (now[1] != before[1] || s->signs == 3 || low <= fmin(before[2], now[2]) + r->inside
                 || (now[2] > before[2] && before[2] <= r->peak + r->half)
                 || (low <= fmax(before[2], now[2]) + r->wide && goes_far(r, before, now))) return r->ask(t, y, NULL);
        else if (now[2] > r->peak) r->peak = now[2];
    }
    else if (r->look == LOOK_AT_VELOCITIES) {
        if (before && before[3] && unexplained(r, before, now)) return r->ask(t, y, NULL);
    }
    else if (r->look == LOOK_ALWAYS) return r->ask(t, y, NULL);
    return 0;
#endif
}

static int accepted(Stepper *r, double t, const double *y)
{
    const int status = seen(r, t, y);
    clear_samples(r->at);
    return status;
}

/* Let a state be the recorded one again; `known` as there. */
static void stand_at(const Stepper *r, const double *record, State *s, int known)
{
    const double *x = record + 4 + r->n;
    const int nx = r->model->s.nx * LANES;
    memcpy(s->x, x, sizeof(double) * 3 * nx);
    memcpy(s->e, x + 3 * nx, sizeof(real) * r->model->s.ne);
    s->t = record[0];
    s->known = known;
    s->whole = 0;
}

/* After a rejected step: its stages may have led the state far away. */
static void rejected(Stepper *r)
{
    r->n_rejected++;
    clear_samples(r->at);
    if (!r->back || !r->recorded) return;
    const double *last = record(r, r->recorded - 1);
    stand_at(r, last, r->at, last[3] != 0.0);
    r->model->transfer_of = NULL;
}

/* A step could be evaluated. Of several cases the failures of the whole motion are counted: one that creeps along a
   dead point, failing every few steps, is followed alone. */
static void evaluated(Stepper *r)
{
    if (LANES == 1) r->reductions = 0;
}

/* The step from t cannot be evaluated: 0 when a shorter one is to be tried. */
static int reduced(Stepper *r, double h_min)
{
    rejected(r);
    if (++r->reductions > r->max_reductions || r->h * r->reduction < h_min) return NOT_EVALUATED;
    r->h *= r->reduction;
    return 0;
}

/* What ends the call after an accepted step to t, or -1. */
static int pause(Stepper *r, double t, int final, int first_steps)
{
    r->begin = r->t;
    r->sizes[1] = r->sizes[0];
    r->sizes[0] = t - r->t;
    r->t = t;
    if (final) return ARRIVED;
    if (t >= r->until) return AT_OUTPUT;
    return r->n_steps - first_steps >= r->most ? PAUSED : -1;
}

static double smallest_step(const Stepper *r)
{
    return 4.0 * DBL_EPSILON * fmax(fmax(fabs(r->t), fabs(r->t_end)), r->t_end - r->t);
}
