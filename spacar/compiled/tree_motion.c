/* Positions, velocities and accelerations of rigid trees, without equations for the positions (theory-system.md
   section 13).

   Outwards, one after the other, with the axis a of a hinge and d = R r of an arm,
        w_q = w_p + a e',   alpha_q = alpha_p + a e'' + w_p x a e',
        v_q = v_p + w x d,   a_q = a_p + alpha x d + w x (w x d).
   Rows of X and `turning` hold the acceleration that all have without the degrees of freedom, less gravity, then the
   transfer functions of these, for which the same holds without the terms of velocities. */

/* The frames of a planar tree: angles, angular velocities and accelerations. */
static void turn_planar(struct Tree *T, const real *x, const real *xd, const real *xdd, const real *e, const real *ed,
    const real *edd)
{
    for (int i = 0; i < T->n_frames; i++) {
        const Frame *f = &T->frames[i];
        real *row = T->turning + i * T->width, *angle = &T->lambda[i], *spin = &T->spin[i];
        if (f->from < 0) {
            *angle = x[f->place];
            *spin = xd[f->place];
            row[0] = xdd[f->place];
        }
        else {
            *angle = T->lambda[f->from] + f->sign * e[f->row];
            *spin = T->spin[f->from] + f->sign * ed[f->row];
            memcpy(row, T->turning + f->from * T->width, sizeof(real) * T->width);
            if (!f->degree) row[0] += f->sign * edd[f->row];
        }
        if (f->degree) row[f->degree] = EVERY(f->from < 0 ? 1.0 : f->sign);
        T->attitude[2 * i] = lanes_cos(*angle - f->angle);
        T->attitude[2 * i + 1] = lanes_sin(*angle - f->angle);
    }
}

/* R of Euler parameters. */
static inline void matrix_of(const real *l, real *R)
{
    const real a = 2.0 * l[0], b = 2.0 * l[1], c = 2.0 * l[2], bb = b * l[1], cc = c * l[2], dd = 2.0 * l[3] * l[3];
    const real ab = a * l[1], ac = a * l[2], ad = a * l[3], bc = b * l[2], bd = b * l[3], cd = c * l[3];
    R[0] = 1.0 - cc - dd; R[1] = bc - ad; R[2] = bd + ac;
    R[3] = bc + ad; R[4] = 1.0 - bb - dd; R[5] = cd - ab;
    R[6] = bd - ac; R[7] = cd + ab; R[8] = 1.0 - bb - cc;
}

/* The frames of a spatial tree: Euler parameters, which turn through with their angle, angular velocities and
   accelerations. */
static void turn_spatial(struct Tree *T, const real *e, const real *ed, const real *edd)
{
    const int width = T->width;
    for (int i = 0; i < T->n_frames; i++) {
        const Frame *f = &T->frames[i];
        if (f->from < 0) continue; /* fixed */
        const real *lp = T->lambda + 4 * f->from, *Rp = T->attitude + 9 * f->from, *spin_p = T->spin + 3 * f->from;
        real *l = T->lambda + 4 * i, *spin = T->spin + 3 * i, *row = T->turning + 3 * i * width, a[3];
        const real half = 0.5 * f->sign * e[f->row], rate = ed[f->row], c = lanes_cos(half), s = lanes_sin(half);
        const real x = s * f->axis[0], y = s * f->axis[1], z = s * f->axis[2];
        l[0] = lp[0] * c - lp[1] * x - lp[2] * y - lp[3] * z;
        l[1] = lp[0] * x + lp[1] * c + lp[2] * z - lp[3] * y;
        l[2] = lp[0] * y + lp[2] * c + lp[3] * x - lp[1] * z;
        l[3] = lp[0] * z + lp[3] * c + lp[1] * y - lp[2] * x;
        matrix_of(l, T->attitude + 9 * i);
        for (int k = 0; k < 3; k++)
            a[k] = f->sign * (Rp[3 * k] * f->axis[0] + Rp[3 * k + 1] * f->axis[1] + Rp[3 * k + 2] * f->axis[2]);
        memcpy(row, T->turning + 3 * f->from * width, sizeof(real) * 3 * width);
        for (int k = 0; k < 3; k++) {
            const int next = (k + 1) % 3, last = (k + 2) % 3;
            spin[k] = spin_p[k] + rate * a[k];
            row[k * width] += rate * (spin_p[next] * a[last] - spin_p[last] * a[next]);
            if (f->degree) row[k * width + f->degree] = a[k];
            else row[k * width] += edd[f->row] * a[k];
        }
    }
}

/* Points with given coordinates: their acceleration, less gravity. */
static void begin_points(const Spec *s, struct Tree *T, const real *xdd)
{
    for (int i = 0; i < T->n_points; i++) {
        const Point *point = &T->points[i];
        if (point->reached == 2) continue;
        for (int c = 0; c < T->dimension; c++)
            T->X[(T->dimension * i + c) * T->width] = xdd[point->c[c]] - s->field[point->c[c]];
    }
}

/* to = from + a first - b second, rows of X. */
static inline void crossed(real *to, const real *from, real a, const real *first, real b, const real *second, int width)
{
    for (int c = 0; c < width; c += ROW)
        *(row_part *)(to + c) =
            *(const row_part *)(from + c) + a * *(const row_part *)(first + c) - b * *(const row_part *)(second + c);
}

/* The points that arms carry: positions, velocities, accelerations. */
static void carry_planar(struct Tree *T, real *x, real *xd)
{
    const int width = T->width;
    for (int i = 0; i < T->n_arms; i++) {
        const Arm *arm = &T->arms[i];
        const int *p = T->points[arm->p].c, *q = T->points[arm->q].c;
        const real c = T->attitude[2 * arm->frame], s = T->attitude[2 * arm->frame + 1], spin = T->spin[arm->frame];
        const real d[2] = {c * arm->r[0] - s * arm->r[1], s * arm->r[0] + c * arm->r[1]};
        const real *turning = T->turning + arm->frame * width, *from = T->X + 2 * arm->p * width;
        real *to = T->X + 2 * arm->q * width;
        x[q[0]] = x[p[0]] + d[0]; xd[q[0]] = xd[p[0]] - spin * d[1];
        x[q[1]] = x[p[1]] + d[1]; xd[q[1]] = xd[p[1]] + spin * d[0];
        memcpy(to, from, sizeof(real) * 2 * width);
        add_row(to, -d[1], turning, width);
        add_row(to + width, d[0], turning, width);
        for (int k = 0; k < 2; k++) to[k * width] -= spin * spin * d[k];
    }
}

static void carry_spatial(struct Tree *T, real *x, real *xd)
{
    const int width = T->width;
    for (int i = 0; i < T->n_arms; i++) {
        const Arm *arm = &T->arms[i];
        const int *p = T->points[arm->p].c, *q = T->points[arm->q].c;
        const real *R = T->attitude + 9 * arm->frame, *spin = T->spin + 3 * arm->frame;
        const real *turning = T->turning + 3 * arm->frame * width, *from = T->X + 3 * arm->p * width;
        real *to = T->X + 3 * arm->q * width, d[3];
        for (int k = 0; k < 3; k++) d[k] = R[3 * k] * arm->r[0] + R[3 * k + 1] * arm->r[1] + R[3 * k + 2] * arm->r[2];
        const real along = spin[0] * d[0] + spin[1] * d[1] + spin[2] * d[2];
        const real square = spin[0] * spin[0] + spin[1] * spin[1] + spin[2] * spin[2];
        for (int k = 0; k < 3; k++) {
            const int next = (k + 1) % 3, last = (k + 2) % 3;
            x[q[k]] = x[p[k]] + d[k];
            xd[q[k]] = xd[p[k]] + spin[next] * d[last] - spin[last] * d[next];
            crossed(to + k * width, from + k * width, d[last], turning + next * width, d[next], turning + last * width,
                width);
            to[k * width] += along * spin[k] - square * d[k];
        }
    }
}

/* Coordinates of orientations, and their rates: lambda' = (0, w) o lambda/2. */
static void write_orientations(const struct Tree *T, real *x, real *xd)
{
    for (int i = 0; i < T->n_orientations; i++) {
        const Orientation *node = &T->orientations[i];
        const int *c = node->c;
        if (T->dimension == 2) {
            x[c[0]] = T->lambda[node->frame] + node->shift;
            xd[c[0]] = T->spin[node->frame];
            continue;
        }
        const real *l = T->lambda + 4 * node->frame, *w = T->spin + 3 * node->frame;
        for (int k = 0; k < 4; k++) x[c[k]] = l[k];
        xd[c[0]] = -0.5 * (w[0] * l[1] + w[1] * l[2] + w[2] * l[3]);
        xd[c[1]] = 0.5 * (w[0] * l[0] + w[1] * l[3] - w[2] * l[2]);
        xd[c[2]] = 0.5 * (w[1] * l[0] + w[2] * l[1] - w[0] * l[3]);
        xd[c[3]] = 0.5 * (w[2] * l[0] + w[0] * l[2] - w[1] * l[1]);
    }
}

/* x and xd, which come with what is given of them and of xdd, e, ed, edd; then X and `turning` belong to them. */
static void follow_tree(const Spec *s, struct Tree *T, real *x, real *xd, const real *xdd, const real *e,
    const real *ed, const real *edd)
{
    begin_points(s, T, xdd);
    if (T->dimension == 2) {
        turn_planar(T, x, xd, xdd, e, ed, edd);
        carry_planar(T, x, xd);
    }
    else {
        turn_spatial(T, e, ed, edd);
        carry_spatial(T, x, xd);
    }
    write_orientations(T, x, xd);
}

/* MX = M X, and w x J w in the first column; X of heavy frames. */
static void weigh(struct Tree *T)
{
    const int width = T->width, d = T->dimension;
    real *X = T->X, *MX = T->MX;
    for (int i = 0; i < d * T->n_points; i++)
        for (int k = i * width; k < (i + 1) * width; k += ROW)
            *(row_part *)(MX + k) = T->mass[i] * *(row_part *)(X + k);
    for (int i = 0; i < T->n_pairs; i++) {
        const Pair *pair = &T->pairs[i];
        add_row(MX + pair->row * width, pair->mass, X + pair->column * width, width);
    }
    for (int i = 0; i < T->n_frames; i++) {
        const Frame *f = &T->frames[i];
        if (!f->heavy) continue;
        const real *turning = T->turning + T->turns * i * width, *R = T->attitude + 9 * i, *w = T->spin + 3 * i,
            *J = f->J;
        real *to = MX + f->at_row * width;
        memcpy(X + f->at_row * width, turning, sizeof(real) * T->turns * width);
        memset(to, 0, sizeof(real) * T->turns * width);
        if (d == 2) { add_row(to, J[0], turning, width); continue; }
        const real own[3][3] = {{J[0], J[1], J[2]}, {J[1], J[3], J[4]}, {J[2], J[4], J[5]}};
        real half[3][3], spun[3];
        for (int k = 0; k < 3; k++)
            for (int l = 0; l < 3; l++)
                half[k][l] = R[3 * k] * own[0][l] + R[3 * k + 1] * own[1][l] + R[3 * k + 2] * own[2][l];
        for (int k = 0; k < 3; k++) {
            spun[k] = EVERY(0.0);
            for (int l = 0; l < 3; l++) {
                const real there = half[k][0] * R[3 * l] + half[k][1] * R[3 * l + 1] + half[k][2] * R[3 * l + 2];
                add_row(to + k * width, there, turning + l * width, width);
                spun[k] += there * w[l];
            }
        }
        for (int k = 0; k < 3; k++)
            to[k * width] += w[(k + 1) % 3] * spun[(k + 2) % 3] - w[(k + 2) % 3] * spun[(k + 1) % 3];
    }
}

/* The moment of forces on the Euler parameters with the coordinates c: lambda'.f = w.moment. */
static void moment_of(const real *x, const real *f, const int *c, real *moment)
{
    const real l0 = 0.5 * x[c[0]], l1 = 0.5 * x[c[1]], l2 = 0.5 * x[c[2]], l3 = 0.5 * x[c[3]];
    moment[0] = -l1 * f[c[0]] + l0 * f[c[1]] - l3 * f[c[2]] + l2 * f[c[3]];
    moment[1] = -l2 * f[c[0]] + l3 * f[c[1]] + l0 * f[c[2]] - l1 * f[c[3]];
    moment[2] = -l3 * f[c[0]] - l2 * f[c[1]] + l1 * f[c[2]] + l0 * f[c[3]];
}

/* Moments of forces at orientations, subtracted from the first column of A. */
static void load_orientations(const struct Tree *T, const real *x, const real *f, int q, real *A)
{
    const int width = T->width;
    for (int i = 0; i < T->n_orientations; i++) {
        const int *c = T->orientations[i].c, frame = T->orientations[i].frame;
        int loaded = 0;
        for (int k = 0; k < T->orientations[i].n; k++) EACH_LANE loaded |= LANE(f[c[k]], w) != 0.0;
        if (!loaded) continue;
        real moment[3] = {f[c[0]]};
        if (T->turns == 3) moment_of(x, f, c, moment);
        const real *turning = T->turning + T->turns * frame * width;
        for (int k = 0; k < q; k++)
            for (int r = 0; r < T->turns; r++) A[k * width] -= moment[r] * turning[r * width + 1 + k];
    }
}

/* xdd of what the tree carries, from those of the degrees of freedom; lambda'' = (0, alpha) o lambda/2 - w.w
   lambda/4. */
static void write_accelerations(const Spec *s, const struct Tree *T, const real *degrees, int q, real *xdd)
{
    const int width = T->width, d = T->dimension;
    real *weights = T->weights;
    weights[0] = EVERY(1.0);
    memcpy(weights + 1, degrees, sizeof(real) * q);
    for (int i = 0; i < T->n_points; i++)
        for (int c = 0; c < d; c++)
            xdd[T->points[i].c[c]] =
                times_row(T->X + (d * i + c) * width, weights, width) + s->field[T->points[i].c[c]];
    for (int i = 0; i < T->n_orientations; i++) {
        const Orientation *node = &T->orientations[i];
        const real *row = T->turning + T->turns * node->frame * width, *l = T->lambda + 4 * node->frame,
            *w = T->spin + 3 * node->frame;
        const int *c = node->c;
        real a[3];
        for (int k = 0; k < T->turns; k++) a[k] = times_row(row + k * width, weights, width);
        if (d == 2) { xdd[c[0]] = a[0]; continue; }
        const real quarter = 0.25 * (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
        xdd[c[0]] = -0.5 * (a[0] * l[1] + a[1] * l[2] + a[2] * l[3]) - quarter * l[0];
        xdd[c[1]] = 0.5 * (a[0] * l[0] + a[1] * l[3] - a[2] * l[2]) - quarter * l[1];
        xdd[c[2]] = 0.5 * (a[1] * l[0] + a[2] * l[1] - a[0] * l[3]) - quarter * l[2];
        xdd[c[3]] = 0.5 * (a[2] * l[0] + a[0] * l[2] - a[1] * l[1]) - quarter * l[3];
    }
}

/* Accelerations of the degrees of freedom, (q); x, xd, e and ed are whole, X and `turning` those of them. */
static int accelerate_tree(Model *m, double t, const real *x, const real *xd, const real *e, const real *ed,
    real *sigma, real *degrees)
{
    const Spec *s = &m->s;
    struct Tree *T = m->tree;
    const int width = T->width, a = s->n_x_dynamic, q = a + s->n_e_dynamic;
    if (stresses(m, t, x, e, xd, ed, sigma)) return NOT_ANSWERED;
    weigh(T);
    for (int i = 0; i < T->n_points; i++)
        for (int c = 0; c < T->dimension; c++) T->MX[(T->dimension * i + c) * width] -= m->applied[T->points[i].c[c]];
    project(T->X, T->MX, width, T->n_rows, q, T->A);
    load_orientations(T, x, m->applied, q, T->A);
    for (int k = a; k < q; k++) T->A[k * width] += sigma[s->e_dynamic + k - a];
    return solve_positive(T->A, width, q, m->b, degrees);
}

/* Evaluate y at t as `evaluate` does, its time derivative into out. OK or a negative reason. */
static int tree_rates(Model *m, State *at, double t, const real *y, real *out)
{
    const Spec *s = &m->s;
    const int nx = s->nx, q = s->n_x_dynamic + s->n_e_dynamic;
    real *x = m->next_x, *xd = m->next_xd, *xdd = m->next_xdd, *degrees = out + q, sum = EVERY(0.0);
    if (take_given(m, at, t, y, x, xd, xdd)) return NOT_ANSWERED;
    follow_tree(s, m->tree, x, xd, xdd, at->given_e, m->given_ed, m->given_edd);
    const int status = accelerate_tree(m, t, x, xd, at->given_e, m->given_ed, at->sigma, degrees);
    if (status) return status;
    write_accelerations(s, m->tree, degrees, q, xdd);
    for (int i = 0; i < nx; i++) sum += xdd[i];
    if (!isfinite(largest_lane(sum))) return NOT_FINITE;
    memcpy(out, y + q, sizeof(real) * q);
    memcpy(at->e, at->given_e, sizeof(real) * s->ne);
    memcpy(at->x, x, sizeof(real) * 3 * nx);
    at->t = t;
    at->known = 1;
    m->transfer_of = NULL;
    m->of_tree = m->matrices_behind = m->factors_behind = 1;
    return OK;
}

/* V and M at the last evaluated state, which the steps of a tree do without, and h. OK or NOT_ANSWERED. */
static int catch_up_matrices(Model *m)
{
    if (!m->matrices_behind) return OK;
    m->matrices_behind = 0;
    return strain(m, m->next_x, m->branch, m->next_e) || inertia(m, m->next_x, m->next_xd, 0) ? NOT_ANSWERED : OK;
}

/* The factors of the position too, which trees do without. OK or a negative reason. */
static int catch_up(Model *m)
{
    if (catch_up_matrices(m)) return NOT_ANSWERED;
    if (!m->factors_behind) return OK;
    m->factors_behind = 0;
    const int status = factor(&m->position, m->values);
    m->factored = !status;
    memcpy(m->factored_x, m->next_x, sizeof(real) * m->s.nx);
    return status;
}
