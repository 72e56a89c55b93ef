/* Many outputs of one motion in one call (`spacar.compiled.output_block`): a state of its own is evaluated at every
   output time, from the output before, or from the begin of the last step when that was long ago. The call ends where
   Python has to look at an output, and after some time, so that Ctrl-C is heard and outputs are handed on. Rows
   of several cases have all lanes of a number behind one another. */
#include <time.h>

static double seconds(void)
{
    struct timespec now;
    timespec_get(&now, TIME_UTC);
    return now.tv_sec + 1e-9 * now.tv_nsec;
}

/* Whether the checks of spacar/dynamics/limits.py surely find nothing at the last evaluated state. */
static int harmless(Model *m, const OutputBlock *p)
{
    if (p->singular > 0.0 && !(spacar_rcond(m, p->singular, p->n_exact) > p->singular)) return 0;
    if (p->foreign || !(spacar_guard(m, p->shown->x) > p->guard)) return 0;
    for (int k = 0; k < p->n_ground; k++) if (!(largest_lane(p->shown->sigma[p->ground[k]]) <= 0.0)) return 0;
    return 1;
}

static double *row_of(const OutputBlock *p, int i) { return p->rows + (size_t)i * p->width; }

/* The state at the i-th output: at the end of its row, or for itself. */
static double *state_of(const Model *m, const OutputBlock *p, int i)
{
    return p->y ? p->y : row_of(p, i) + 6 * m->s.nx + 4 * m->s.ne;
}

/* Evaluate the i-th output, whose y stands at `state_of`; whether the call goes on. */
static int show(Model *m, OutputBlock *p, int i)
{
    State *s = p->shown;
    const int nx = m->s.nx, ne = m->s.ne;
    p->done = i + 1;
    p->last = NOT_SHOWN;
    p->status = spacar_evaluate(m, s, p->t[i], (const real *)state_of(m, p, i), p->exact, p->jump);
    if (p->status < 0) return 0;
    memcpy(row_of(p, i), s->x, sizeof(real) * (6 * nx + 4 * ne)); /* as `spacar_state` has laid them out */
    const int told = m->s.user && m->s.user->lost && ask(m->s.asking, ASK_OUTPUT, 0, p->t[i]);
    p->last = !told && harmless(m, p) ? HARMLESS : LOOKED_AT;
    return p->last == HARMLESS;
}

/* Outputs of a motion that is all prescribed, n of them; what is counted are the iterations of their positions. */
static int spacar_show(Model *m, OutputBlock *p)
{
    const double begin = seconds();
    p->done = 0;
    memset(p->counted, 0, sizeof p->counted);
    for (int go_on = 1; go_on && p->done < p->n;) {
        go_on = show(m, p, p->done);
        p->work[5 * (p->done - 1) + 4] = p->status;
        if (seconds() - begin >= p->longest) break;
    }
    return 0;
}

/* `StepHistory.lead`: an output that is far from the last one begins at the begin of its step. */
static void lead(Stepper *r, OutputBlock *p)
{
    if (p->since > p->far && r->recorded > 1 && r->capacity > 1) {
        const double *begin = record(r, r->recorded - 2);
        if (begin[3] != 0.0 && record(r, r->recorded - 1)[3] != 0.0) stand_at(r, begin, p->shown, 2);
    }
    p->since = 0;
}

/* Does F at the i-th output, which has been evaluated, tell other rates than the polynomial of the step (drive.py)? */
static int disagrees(const Stepper *r, const void *adams, const OutputBlock *p, int i)
{
    const double h = r->sizes[0], t = p->t[i], low = fmax(r->t - h, t - 1e-4 * h), high = fmin(r->t, t + 1e-4 * h);
    const int first = r->n - p->n_rates;
    const double *row = row_of(p, i), *y = state_of(r->model, p, i);
    double *before = p->around, *behind = before + r->n, sum = 0.0;
    spacar_adams_value(r, adams, low, before);
    spacar_adams_value(r, adams, high, behind);
    for (int k = 0; k < p->n_rates; k++) {
        const int j = first + k;
        const double slope = (behind[j] - before[j]) / (high - low), weight = r->atol[j] + r->rtol * fabs(y[j]);
        const double scaled = h * (row[p->rates[k]] - slope) / weight;
        sum += scaled * scaled;
    }
    return sqrt(sum) > p->suspect;
}

typedef int (*Go)(Stepper *r, void *method);

/* Steps, and the outputs in them, those in the step that was made last first. n: room for outputs, of which there is
   one at least. As the calls that make steps; AT_OUTPUT: there may be more of them in the last step. */
static int pass(Stepper *r, void *method, Go go, const double *end, OutputBlock *p)
{
    const double begin = seconds();
    p->done = 0;
    p->last = HARMLESS;
    memset(p->counted, 0, sizeof p->counted);
    for (;;) {
        while (p->t[p->done] <= r->t) {
            const int i = p->done;
            double *y = state_of(r->model, p, i);
            if (p->t[i] == r->t) memcpy(y, end, sizeof(double) * r->n);
            else if (!p->value) spacar_adams_value(r, method, p->t[i], y);
            else if (p->value(p->t[i], y)) return INTERRUPTED;
            const int now[] = {r->n_steps, r->n_rhs, 0, r->n_rejected, 0};
            for (int k = 0; k < 5; k++) p->work[5 * i + k] = now[k] - p->counted[k];
            lead(r, p);
            const int go_on = show(r->model, p, i);
            if (p->suspect > 0.0 && p->last != NOT_SHOWN && p->t[i] < r->t && disagrees(r, method, p, i)) {
                p->done = i;
                p->last = SUSPECT;
                return AT_OUTPUT;
            }
            memcpy(p->counted, now, sizeof now);
            if (!go_on || p->done == p->n) return AT_OUTPUT;
        }
        if (r->t >= r->t_end) return ARRIVED;
        if (p->done && (r->n_steps >= p->steps || seconds() - begin >= p->longest)) return AT_OUTPUT;
        const int before = r->n_steps;
        r->until = p->t[p->done];
        const int status = go(r, method);
        p->since += r->n_steps - before;
        if (status != ARRIVED && status != AT_OUTPUT) return status;
    }
}

static int go_adams(Stepper *r, void *method) { return spacar_adams(r, method); }
static int go_runge_kutta(Stepper *r, void *method) { return spacar_runge_kutta(r, method); }

static int spacar_pass_adams(Stepper *r, Adams *a, OutputBlock *p) { return pass(r, a, go_adams, a->y, p); }
static int spacar_pass_runge_kutta(Stepper *r, RungeKutta *k, OutputBlock *p)
{
    return pass(r, k, go_runge_kutta, k->y_new, p);
}
