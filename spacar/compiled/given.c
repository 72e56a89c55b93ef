/* What is given of a state: prescribed motions, degrees of freedom, kinematic coordinates. */

/* Value, rate and acceleration of a prescribed motion. */
static void prescribed(const Spec *s, const real *row, double t, real *value, real *rate, real *acceleration)
{
    *value = s->polynomial ? row[0] + t * (row[1] + 0.5 * t * row[2]) : row[0];
    *rate = s->polynomial ? row[1] + t * row[2] : row[1];
    *acceleration = row[2];
}

/* What is given of x, xd and xdd at t, and of e and its rates; the rest of x stays, that of xd and xdd is zero. OK or NOT_ANSWERED. */
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
