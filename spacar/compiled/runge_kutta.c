/* Explicit Runge-Kutta codes with variable steps, as spacar/integrators/runge_kutta.py and the step loop of
   drive.py. */
/* A trial step; its error over the tolerance is in `error`. 0, 1, 2 as AskRate. */
static int rk_trial(Stepper *r, RungeKutta *p)
{
    const int n = r->n;
    const double h = r->h;
    double square[2][LANES] = {{0.0}}, *stage = p->scaled;
    p->h = h;
    for (int k = 1; k < p->rows; k++) {
        advance(p->y, h, p->K, n, p->a + k * p->rows, k, n, stage);
        const int status = derivative(r, r->t + p->c[k] * h, stage, p->K + k * n);
        if (status) return status;
        leave_motion(r->model);
    }
    advance(p->y, h, p->K, n, p->b, p->stages, n, p->y_new);
    for (int k = p->two; k >= 0; k--) { /* the first one stays in `scaled` */
        combine(p->K, n, p->errors + k * p->estimated, p->estimated, n, p->scaled);
        for (int i = 0; i < n; i++) {
            p->scaled[i] /= r->atol[i] + r->rtol * fmax(fabs(p->y[i]), fabs(p->y_new[i]));
            square[k][i % LANES] += p->scaled[i] * p->scaled[i] * LANES / n;
        }
    }
    r->error = 0.0; /* the largest one of a case */
    EACH_LANE {
        const double s0 = square[0][w], s1 = square[1][w];
        const double error = p->two ? p->safety * h * s0 / sqrt(s0 + 0.01 * s1 + p->tiny) : h * sqrt(s0);
        if (!(error <= r->error)) r->error = error;
    }
    if (!(r->error <= 1.0) || p->rows > p->stages) return 0;
    return derivative(r, r->t + h, p->y_new, p->K + p->stages * n); /* first stage of the next step */
}

/* Steps until the next output or the end; y_new and the last row of K are those of the last accepted step. */
static int spacar_runge_kutta(Stepper *r, RungeKutta *p)
{
    const int n = r->n, first_steps = r->n_steps;
    const double h_min = smallest_step(r);
    for (;;) {
        memcpy(p->y, p->y_new, sizeof(double) * n);
        memcpy(p->K, p->K + p->stages * n, sizeof(double) * n);
        double growth = p->largest;
        int final;
        evaluated(r);
        for (;;) {
            final = r->t + fmin(r->stretch * r->h, fmax(r->h, r->longest)) >= r->t_end;
            if (final) r->h = r->t_end - r->t;
            const int status = rk_trial(r, p);
            if (status == 2) return INTERRUPTED;
            if (status) {
                if (reduced(r, h_min)) return NOT_EVALUATED;
                growth = 1.0;
                continue;
            }
            if (r->error <= 1.0) break;
            rejected(r);
            growth = 1.0;
            const double h = r->h * fmax(p->smallest, 0.9 * pow(r->error, -1.0 / p->exponent));
            if (!(h >= h_min)) return TOO_SMALL;
            r->h = h;
        }
        const double t = final ? r->t_end : r->t + r->h;
        if (accepted(r, t, p->y_new)) return INTERRUPTED;
        double factor = p->largest;
        if (r->error > 0.0) factor = fmin(p->largest, fmax(p->smallest, 0.9 * pow(r->error, -1.0 / p->exponent)));
        r->h = fmax(fmin(r->h * fmin(growth, factor), r->longest), h_min);
        const int end = pause(r, t, final, first_steps);
        if (end >= 0) return end;
    }
}
