/* Code 0, as spacar/integrators/adams.py; see there for formulas and sources. */
/* Weighted norm of a, or of a + factor b; the largest one of a case. */
static double adams_norm(const Adams *a, int n, const double *v, double factor, const double *w)
{
    double sum[LANES] = {0.0};
    for (int i = 0; i < n; i += LANES)
        for (int l = 0; l < LANES; l++) {
            const double scaled = (v[i + l] + (w ? factor * w[i + l] : 0.0)) * a->weight[i + l];
            sum[l] += scaled * scaled;
        }
    double most = sum[0];
    for (int l = 1; l < LANES; l++) if (!(sum[l] <= most)) most = sum[l];
    return sqrt(most);
}

static void adams_weights(const Stepper *r, Adams *a)
{
    for (int i = 0; i < r->n; i++) a->weight[i] = 1.0 / (fabs(a->y[i]) * r->rtol + r->atol[i]);
}

/* Coefficients of a step h of order k whose last `equal` steps are equal: psi at its end, g and sigma (k + 1), beta
   (k). */
static void adams_coefficients(double h, int k, int equal, const double *psi, double *psi_new, double *g, double *sigma,
                               double *beta)
{
    double alpha[MAX_ORDER], row[MAX_ORDER], b = 1.0, s = 1.0;
    psi_new[0] = h;
    for (int i = 0; i < MAX_ORDER; i++) psi_new[i + 1] = h + psi[i];
    sigma[0] = 1.0;
    for (int i = 0; i < k; i++) {
        alpha[i] = 1.0 / (i + 1);
        if (i >= equal) {
            b *= psi_new[i - 1] / psi[i - 1];
            alpha[i] = h / psi_new[i];
            s *= (i + 1) * alpha[i];
        }
        beta[i] = b;
        sigma[i + 1] = s;
        row[i] = 1.0 / ((i + 1.0) * (i + 2.0));
    }
    g[0] = 1.0;
    g[1] = row[0];
    for (int i = 1; i < k; i++) {
        for (int q = 0; q < k - i; q++) row[q] -= alpha[i] * row[q + 1];
        g[i + 1] = row[0];
    }
}

static double adams_next_size(double h, int k, double error)
{
    if (error * ldexp(1.0, k + 1) <= 0.5) return 2.0 * h;
    if (error <= 0.5) return h;
    return h * fmin(0.9, fmax(0.5, pow(0.5 / error, 1.0 / (k + 1))));
}

/* Start at (t, y) of Stepper, whose h is the largest first step. */
static int spacar_adams_begin(Stepper *r, Adams *a)
{
    const size_t n = r->n;
    a->phi = a->memory;
    a->expected = a->phi + (MAX_ORDER + 1) * n;
    a->y = a->expected + (MAX_ORDER + 1) * n;
    a->y_new = a->y + n;
    a->predicted = a->y_new + n;
    a->d = a->predicted + n;
    a->weight = a->d + n;
    const int status = derivative(r, r->t, a->y, a->phi);
    if (status) return status;
    adams_weights(r, a);
    a->h_min = smallest_step(r);
    const double slope = adams_norm(a, r->n, a->phi, 0.0, NULL);
    if (16.0 * r->h * r->h * slope > 1.0) r->h = 0.25 / sqrt(slope);
    r->h = fmax(r->h, a->h_min);
    a->order = 1;
    a->k_old = a->equal = a->rejections = r->reductions = 0;
    a->h_old = 0.0;
    a->starting = 1;
    started(r, a->y);
    return 0;
}

/* A trial step of size h and order k to t_new: its errors at orders k, k - 1, k - 2 in e, and when the first of them is
   accepted y_new and the derivative there in d. 0, 1, 2 as AskRate. */
static int adams_trial(Stepper *r, Adams *a, double t_new, int k, const double *g, const double *sigma, const double
    *beta, double *e)
{
    const int n = r->n;
    const double h = r->h, *gamma = a->gamma_star;
    double *expected = a->expected;
    for (int i = 0; i < n; i++) expected[i] = 0.0;
    for (int j = k - 1; j >= 0; j--) {
        const double *phi = a->phi + j * n, b = beta[j], weight = g[j] * b;
        double *sum = expected + (j + 1) * n;
        const double *above = expected + (j + 2) * n;
        for (int i = 0; i < n; i++) {
            expected[i] += weight * phi[i];
            sum[i] = (j + 1 < k ? above[i] : 0.0) + b * phi[i];
        }
    }
    for (int i = 0; i < n; i++) a->predicted[i] = a->y[i] + h * expected[i];
    int status = derivative(r, t_new, a->predicted, a->d);
    if (status) return status;
    for (int i = 0; i < n; i++) a->d[i] -= expected[n + i];
    const double size = adams_norm(a, n, a->d, 0.0, NULL);
    r->error = h * fabs(g[k - 1] - g[k]) * size;
    e[0] = h * gamma[k] * sigma[k] * size;
    e[1] = k > 1 ? h * gamma[k - 1] * sigma[k - 1] * adams_norm(a, n, expected + k * n, 1.0, a->d) : 0.0;
    e[2] = k > 2 ? h * gamma[k - 2] * sigma[k - 2] * adams_norm(a, n, expected + (k - 1) * n, 1.0, a->d) : 0.0;
    if (!(r->error <= 1.0)) return 0;
    for (int i = 0; i < n; i++) a->y_new[i] = a->predicted[i] + h * g[k] * a->d[i];
    return derivative(r, t_new, a->y_new, a->d);
}

/* y(t) in the last step, which ended at Stepper's t, from the polynomial of the step. */
static int spacar_adams_value(const Stepper *r, const Adams *a, double t, double *out)
{
    const int n = r->n, k = a->k;
    const double tau = t - r->t;
    double row[MAX_ORDER + 1], before = 0.0;
    for (int q = 0; q <= k; q++) row[q] = 1.0 / (q + 1);
    for (int i = 0; i < n; i++) out[i] = a->y[i] + tau * a->phi[i];
    for (int j = 0; j < k; j++) {
        const double gamma = (tau + before) / a->psi[j], eta = tau / a->psi[j];
        for (int q = 0; q < k - j; q++) row[q] = gamma * row[q] - eta * row[q + 1];
        before = a->psi[j];
        for (int i = 0; i < n; i++) out[i] += tau * row[0] * a->phi[(j + 1) * n + i];
    }
    return 0;
}

/* Steps until the next output or the end. The first call goes on from `spacar_adams_begin`, others from the last
   call. */
static int spacar_adams(Stepper *r, Adams *a)
{
    const int n = r->n, first_steps = r->n_steps;
    double psi[MAX_ORDER + 2], g[MAX_ORDER + 2], sigma[MAX_ORDER + 2], beta[MAX_ORDER + 1], e[3];
    for (;;) {
        const int final = r->t + r->stretch * r->h >= r->t_end;
        if (final) r->h = r->t_end - r->t;
        const double h = r->h, t_new = final ? r->t_end : r->t + h;
        int k = a->order, lower, raise;
        int equal = h == a->h_old ? a->equal + 1 : 1;
        if (equal > a->k_old + 1) equal = a->k_old + 1;
        adams_coefficients(h, k, equal, a->psi, psi, g, sigma, beta);
        const int status = adams_trial(r, a, t_new, k, g, sigma, beta, e);
        if (status == 2) return INTERRUPTED;
        if (status) {
            a->starting = 0;
            if (reduced(r, a->h_min)) return NOT_EVALUATED;
            a->order = k > 1 ? k - 1 : 1;
            continue;
        }
        lower = (k > 2 && fmax(e[1], e[2]) <= e[0]) || (k == 2 && e[1] <= 0.5 * e[0]);
        if (!(r->error <= 1.0)) {
            rejected(r);
            a->starting = 0;
            if (0.5 * h < a->h_min) return TOO_SMALL;
            double factor = 0.5;
            if (++a->rejections > 3 && e[0] > 2.0) factor = sqrt(0.5 / e[0]);
            r->h = fmax(factor * h, a->h_min);
            a->order = a->rejections >= 3 ? 1 : k - lower;
            continue;
        }
        double *phi_k = a->phi + k * n, e_raised = 0.0;
        for (int i = 0; i < n; i++) a->d[i] -= a->expected[n + i];
        raise = k + 1 <= equal;
        if (raise) e_raised = h * a->gamma_star[k + 1] * adams_norm(a, n, a->d, -1.0, phi_k);
        for (int j = 0; j < k; j++)
            for (int i = 0; i < n; i++) a->phi[j * n + i] = a->expected[(j + 1) * n + i] + a->d[i];
        memcpy(phi_k, a->d, sizeof(double) * n);
        memcpy(a->y, a->y_new, sizeof(double) * n);
        memcpy(a->psi, psi, sizeof a->psi);
        a->k = a->k_old = k;
        a->equal = equal;
        a->h_old = h;
        a->rejections = 0;
        evaluated(r);
        adams_weights(r, a);
        if (accepted(r, t_new, a->y)) return INTERRUPTED;
        /* order and size of the next step */
        a->starting = a->starting && !lower && k < MAX_ORDER;
        if (a->starting) { k++; r->h = 2.0 * h; }
        else {
            if (!lower && raise) {
                if (k > 1 && e[1] <= fmin(e[0], e_raised)) lower = 1;
                else if (k < MAX_ORDER && e_raised < (k > 1 ? e[0] : 0.5 * e[0])) { k++; e[0] = e_raised; }
            }
            if (lower) { k--; e[0] = e[1]; }
            r->h = fmax(adams_next_size(h, k, e[0]), a->h_min);
        }
        a->order = k;
        const int end = pause(r, t_new, final, first_steps);
        if (end >= 0) return end;
    }
}
