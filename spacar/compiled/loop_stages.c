/* Stages of a simulated loop: a mechanism, and blocks that are affine in what is read of it, in their states and in
   signals that are given at the time,

       (loads of the mechanism, rates of the blocks' states) = matrix (1, signals, states, what is read).

   A state is (q, states of blocks, v), with q and v those of a mechanism without kinematic coordinates
   (spacar/simulation/stepping.py). */
static int loop_rates(const Loop *l, double t, const double *given, const double *y, double *out)
{
#if LANES == 1
    Model *m = l->model;
    const Spec *s = &m->s;
    const int a = s->n_x_dynamic, b = s->n_e_dynamic, q = a + b, n = l->n_states,
        width = 1 + l->n_given + n + l->n_read;
    double *read = l->z + 1 + l->n_given + n;
    l->z[0] = 1.0;
    memcpy(l->z + 1, given, sizeof(double) * l->n_given);
    memcpy(l->z + 1 + l->n_given, y + q, sizeof(double) * n);
    memcpy(l->own, y, sizeof(double) * q);
    memcpy(l->own + q, y + q + n, sizeof(double) * q);
    /* positions and rates, with the last loads */
    if (spacar_rhs(m, l->at, t, l->own, l->rates, l->converged, l->jump) < 0) return 1;
    memcpy(l->at->ed + s->e_dynamic, l->own + q + a, sizeof(double) * b);
    for (int k = 0; k < l->n_read; k++) read[k] = l->at->x[l->read[k]];
    for (int i = 0; i < l->n_load + n; i++) {
        const double *row = l->matrix + (size_t)i * width;
        double sum = 0.0;
        for (int k = 0; k < width; k++) sum += row[k] * l->z[k];
        if (i < l->n_load) ((double *)s->force)[l->load[i]] = sum;
        else out[q + i - l->n_load] = sum;
    }
    m->evaluations++;
    if (spacar_rhs(m, l->at, t, l->own, l->rates, l->converged, l->jump) < 0) return 1;
    memcpy(out, l->rates, sizeof(double) * q);
    memcpy(out + q + n, l->rates + q, sizeof(double) * q);
    leave_motion(m);
    return 0;
#else
    return 1;
#endif
}

/* As `spacar_stages`, of a loop; `given`: its signals at the times of the stages, (n, n_given). */
static int spacar_loop_stages(const Loop *l, int from, int n, const double *c, const double *a, double t, double h,
    double earliest, double latest, const double *given, const double *y, double *K, int stride, double *stage)
{
    for (int i = from; i < n; i++) {
        advance(y, h, K, stride, a + i * n, i, stride, stage);
        if (loop_rates(l, fmin(fmax(t + c[i] * h, earliest), latest), given + i * l->n_given, stage, K + i * stride))
            return i;
    }
    return n;
}
