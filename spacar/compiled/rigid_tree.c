/* Rigid trees: mechanisms that open out from the ground without loops, through rigid elements, hinges and given
   coordinates. Here they are found; tree_motion.c evaluates them without equations for the positions, outputs.c what
   outputs have besides (theory-system.md section 13).

   Frames are orientations: fixed, the given angle of a planar node, or turned against another frame by the first
   deformation of a hinge. Arms carry points: x_q = x_p + R r of a frame. The inertia of a rigid element is that of
   masses at its ends and a rest J about p, which a rod does not have:
       T = (w_pp v_p.v_p + 2 w_pq v_p.v_q + w_qq v_q.v_q + w.J w)/2,
   so that its mass is w_pp + 2 w_pq + w_qq, its first moment (w_pq + w_qq) d with d = x_q - x_p, its inertia w_qq
   (d.d I - d d^T) + J. */
static void tree_end(Model *m)
{
    give_back(&m->tree_memory);
    m->tree = NULL;
}

static int is_calculable(const Spec *s, int i) { return i >= s->n_fixed_x && i < s->n_fixed_x + s->n_position; }

static int is_given(const Spec *s, const int *c, int n)
{
    for (int k = 0; k < n; k++) if (is_calculable(s, c[k])) return 0;
    return 1;
}

/* The column of a dynamic coordinate, or 0. */
static int degree_of(const Spec *s, int i)
{
    const int k = i - s->x_dynamic;
    return k >= 0 && k < s->n_x_dynamic ? 1 + k : 0;
}

/* Is a zero in all lanes, but for rounding of numbers of that size? */
static int vanishes(real a, real size)
{
    EACH_LANE if (!(fabs(LANE(a, w)) <= 64.0 * DBL_EPSILON * fabs(LANE(size, w)))) return 0;
    return 1;
}

/* Are the deformations from `first` on zero at the reference, where the tree takes its arms? (Not with DRPINBOD.) */
static int is_undeformed(const Spec *s, const Batch *k, int i, int first)
{
    real x[MAX_X], e[MAX_E], V[MAX_E * MAX_X], size = EVERY(0.0);
    for (int j = 0; j < k->nxe; j++) {
        x[j] = s->x0[k->x[i * k->nxe + j]];
        EACH_LANE LANE(size, w) += fabs(LANE(x[j], w));
    }
    if (k->nee) STRAIN[k->kind](x, k->p + i * k->np, e, V);
    for (int r = first; r < k->nee; r++) if (!vanishes(e[r], size)) return 0;
    return 1;
}

/* The elements that join nodes, and their nodes; `of` (nx): the node that begins at a coordinate, -1. 0: one of them
   joins otherwise. */
static int find_parts(const Spec *s, struct Tree *T, int *of)
{
    for (int b = 0; b < s->n_batches; b++) {
        const Batch *k = &s->batches[b];
        const Joint *joint = k->kind < 0 ? NULL : &JOINT[k->kind];
        if (!joint || joint->how == APART) return 0;
        for (int i = 0; i < k->n; i++) {
            const int *x = k->x + i * k->nxe, *e = k->e + i * k->nee, free_row = joint->how == TURNING;
            for (int r = free_row; r < k->nee; r++) if (e[r] >= s->e_input) return 0;
            if ((free_row && e[0] >= s->n_equations) || !is_undeformed(s, k, i, free_row)) return 0;
            Part part = {k, i, {-1, -1, -1, -1}, 0};
            for (int j = 0; j < 4; j++) {
                if (joint->end[j] < 0) continue;
                const int *c = x + joint->end[j];
                const int is_point = j == AT_P || j == AT_Q, turns = T->dimension == 2 ? 1 : 4;
                if (of[*c] < 0 && is_point) {
                    of[*c] = T->n_points;
                    memcpy(T->points[T->n_points++].c, c, sizeof(int) * T->dimension);
                }
                else if (of[*c] < 0) {
                    Orientation *node = &T->orientations[of[*c] = T->n_orientations++];
                    memcpy(node->c, c, sizeof(int) * turns);
                    node->n = turns;
                    node->frame = -1;
                }
                part.node[j] = of[*c];
            }
            T->parts[T->n_parts++] = part;
        }
    }
    return 1;
}

static Frame *new_frame(struct Tree *T, Orientation *node)
{
    Frame *frame = &T->frames[node->frame = T->n_frames++];
    frame->from = frame->place = frame->row = -1;
    return frame;
}

/* What is given, from which the tree opens. 0: an orientation that moves without a hinge. */
static int begin_tree(const Spec *s, struct Tree *T)
{
    for (int i = 0; i < T->n_points; i++) {
        Point *point = &T->points[i];
        point->reached = is_given(s, point->c, T->dimension);
        for (int c = 0; c < T->dimension; c++) point->degree[c] = degree_of(s, point->c[c]);
    }
    for (int i = 0; i < T->n_orientations; i++) {
        Orientation *node = &T->orientations[i];
        if (T->dimension == 3) /* the same axes for all: as the reference has them */
            for (int k = 0; k < 4; k++) EACH_LANE if (LANE(s->x0[node->c[k]], w) != (k == 0)) return 0;
        const int own = T->dimension == 3; /* lambda0 is calculable from the others */
        if (!is_given(s, node->c + own, node->n - own)) continue;
        Frame *frame = new_frame(T, node);
        if (own) {
            for (int k = 1; k < 4; k++) if (node->c[k] >= s->n_fixed_x) return 0;
            continue;
        }
        frame->place = node->c[0];
        frame->degree = degree_of(s, frame->place);
        frame->angle = s->x0[frame->place];
    }
    return 1;
}

/* The outer end of a part is reached; the orientation there may be NULL. */
static void add_link(struct Tree *T, const Part *part, int point, const Orientation *node, int frame)
{
    Link *link = &T->links[T->n_links++];
    link->part = (int)(part - T->parts);
    link->point = point;
    link->node = node ? (int)(node - T->orientations) : -1;
    link->frame = frame;
}

/* Reach the other end of a part: 1; 0 when none of its ends is reached yet, -1 when both are: a loop. */
static int reach(const Spec *s, struct Tree *T, Part *part)
{
    const Batch *k = part->batch;
    const int turning = JOINT[k->kind].how == TURNING;
    Orientation *p = &T->orientations[part->node[TURN_P]], *q = part->node[TURN_Q] < 0 ? NULL
        : &T->orientations[part->node[TURN_Q]];
    if (q && p->frame >= 0 && q->frame >= 0) return -1;
    Orientation *known = p->frame >= 0 ? p : q, *next = p->frame >= 0 ? q : p;
    const int reached = known && known->frame >= 0;
    if (turning) {
        if (!reached) return 0;
        const int row = k->e[part->i * k->nee], degree = row - s->e_dynamic;
        Frame *frame = new_frame(T, next);
        frame->from = known->frame;
        frame->row = row;
        frame->degree = degree >= 0 && degree < s->n_e_dynamic ? 1 + s->n_x_dynamic + degree : 0;
        frame->sign = known == p ? 1.0 : -1.0;
        frame->angle = s->x0[next->c[0]];
        for (int c = 0; c < 3 && T->dimension == 3; c++) frame->axis[c] = k->p[part->i * k->np + c];
        add_link(T, part, -1, next, p->frame);
        return 1;
    }
    const int from_p = T->points[part->node[AT_P]].reached, from_q = T->points[part->node[AT_Q]].reached;
    if (from_p && from_q) return -1;
    if (!reached || !(from_p || from_q)) return 0;
    if (next) {
        next->frame = known->frame;
        next->shift = s->x0[next->c[0]] - T->frames[known->frame].angle;
    }
    Arm *arm = &T->arms[T->n_arms++];
    arm->p = part->node[from_p ? AT_P : AT_Q];
    arm->q = part->node[from_p ? AT_Q : AT_P];
    arm->frame = known->frame;
    Point *end = &T->points[arm->q];
    for (int c = 0; c < T->dimension; c++) arm->r[c] = s->x0[end->c[c]] - s->x0[T->points[arm->p].c[c]];
    end->reached = 2;
    add_link(T, part, arm->q, next, arm->frame);
    return 1;
}

/* Whether all calculable coordinates are reached, each once, and all degrees of freedom are among the columns. */
static int is_whole(const Spec *s, const struct Tree *T)
{
    int n = 0;
    for (int i = 0; i < T->n_points; i++) {
        const Point *point = &T->points[i];
        if (!point->reached) return 0;
        for (int c = 0; c < T->dimension; c++) {
            if (point->reached == 2 && !is_calculable(s, point->c[c])) return 0;
            n += is_calculable(s, point->c[c]) || point->degree[c];
        }
    }
    for (int i = 0; i < T->n_orientations; i++) {
        const Orientation *node = &T->orientations[i];
        if (node->frame < 0) return 0;
        for (int c = 0; c < node->n; c++) n += is_calculable(s, node->c[c]) || degree_of(s, node->c[c]);
    }
    return n == s->n_position + s->n_x_dynamic;
}

/* Inertia of a rigid element for (v_p, w) at the reference: B^T M B with the rates B of its coordinates; (6, 6), or
   (3, 3). */
static void rigid_inertia(const struct Tree *T, const Batch *k, const real *x, const real *p, real (*I)[6])
{
    const int d = T->dimension, n = d + T->turns, at_q = JOINT[k->kind].end[AT_Q], nxe = k->nxe;
    const signed char *end = JOINT[k->kind].end;
    real M[MAX_X * MAX_X] = {0}, he[MAX_X], at_rest[MAX_X] = {0}, B[MAX_X][6] = {0}, r[3] = {0};
    INERTIA[k->kind](x, at_rest, p, M, he);
    for (int c = 0; c < d; c++) {
        B[c][c] = B[at_q + c][c] = EVERY(1.0);
        r[c] = x[at_q + c] - x[c];
    }
    if (d == 2) {
        B[at_q][2] = -r[1]; B[at_q + 1][2] = r[0];
        B[end[TURN_P]][2] = B[end[TURN_Q]][2] = EVERY(1.0);
    }
    else for (int c = 0; c < 3; c++) { /* w x r; lambda' = (0, w)/2 */
        const int next = (c + 1) % 3, last = (c + 2) % 3;
        B[at_q + c][3 + next] = r[last];
        B[at_q + c][3 + last] = -r[next];
        B[end[TURN_P] + 1 + c][3 + c] = B[end[TURN_Q] + 1 + c][3 + c] = EVERY(0.5);
    }
    memset(I, 0, 6 * sizeof *I);
    for (int a = 0; a < nxe; a++) {
        real MB[6] = {0};
        int moves = 0;
        for (int b = 0; b < nxe; b++) {
            if (vanishes(M[a * nxe + b], EVERY(0.0))) continue; /* most of a rod */
            moves = 1;
            for (int j = 0; j < n; j++) MB[j] += M[a * nxe + b] * B[b][j];
        }
        for (int i = 0; moves && i < n; i++) for (int j = 0; j < n; j++) I[i][j] += B[a][i] * MB[j];
    }
}

/* The masses of a rigid element with mass M(x). 0: they do not lie on the line of its nodes. */
static int add_rod(const Spec *s, struct Tree *T, const Part *part)
{
    const Batch *k = part->batch;
    const int d = T->dimension;
    real x[MAX_X], I[6][6], r[3], square = EVERY(0.0), along = EVERY(0.0), moment[3], J[6];
    for (int j = 0; j < k->nxe; j++) x[j] = s->x0[k->x[part->i * k->nxe + j]];
    rigid_inertia(T, k, x, k->p + part->i * k->np, I);
    const real mass = I[0][0];
    for (int i = 0; i < d; i++) {
        r[i] = x[JOINT[k->kind].end[AT_Q] + i] - x[i];
        square += r[i] * r[i];
        for (int j = 0; j < d; j++) if (!vanishes(I[i][j] - (i == j ? mass : EVERY(0.0)), mass)) return 0;
    }
    EACH_LANE if (!(LANE(square, w) > 0.0)) return 0;
    if (d == 2) { moment[0] = I[1][2]; moment[1] = -I[0][2]; }
    else { moment[0] = I[1][5]; moment[1] = I[2][3]; moment[2] = I[0][4]; }
    for (int i = 0; i < d; i++) along += moment[i] * r[i] / square;
    const real length = lanes_sqrt(square);
    for (int i = 0; i < d; i++) if (!vanishes(moment[i] - along * r[i], mass * length)) return 0;
    const real trace = d == 2 ? I[2][2] : 0.5 * (I[3][3] + I[4][4] + I[5][5]), at_q = trace / square;
    Frame *frame = &T->frames[T->orientations[part->node[TURN_P]].frame];
    for (int i = 0, n = 0; i < 3 && d == 3; i++)
        for (int j = i; j < 3; j++, n++) {
            J[n] = I[3 + i][3 + j] - at_q * ((i == j ? square : EVERY(0.0)) - r[i] * r[j]);
            if (!vanishes(J[n], trace)) frame->heavy = 1;
            frame->J[n] += J[n];
        }
    for (int c = 0; c < d; c++) {
        const int p = d * part->node[AT_P] + c, q = d * part->node[AT_Q] + c;
        T->mass[p] += mass - 2.0 * along + at_q;
        T->mass[q] += at_q;
        T->pairs[T->n_pairs++] = (Pair){p, q, along - at_q};
        T->pairs[T->n_pairs++] = (Pair){q, p, along - at_q};
    }
    return 1;
}

/* All masses. 0: some are not those of points, rods and rotations. `row` (nx): room for the rows of coordinates. */
static int add_masses(const Spec *s, struct Tree *T, int *row)
{
    const int n = T->dimension * T->n_points;
    for (int i = 0; i < T->n_parts; i++) {
        const Part *part = &T->parts[i];
        const Batch *k = part->batch;
        if (!k->inertia) continue;
        if (JOINT[k->kind].how == RIGID && !add_rod(s, T, part)) return 0;
        if (k->kind != BODY) continue;
        Frame *frame = &T->frames[T->orientations[part->node[TURN_P]].frame];
        for (int c = 0; c < 6; c++) frame->J[c] += k->p[part->i * k->np + c];
        frame->heavy = 1;
    }
    for (int i = 0; i < s->nx; i++) row[i] = -1;
    for (int i = 0; i < n; i++) row[T->points[i / T->dimension].c[i % T->dimension]] = i;
    for (int i = 0; i < T->n_orientations; i++) row[T->orientations[i].c[0]] = n + i;
    for (int k = 0; k < s->n_constant; k++) {
        const int i = row[s->constant_row[k]], j = row[s->constant_column[k]];
        if (i >= 0 && i == j && i < n) T->mass[i] += s->constant_mass[k];
        else if (i >= 0 && i == j && T->turns == 1) {
            Frame *frame = &T->frames[T->orientations[i - n].frame];
            frame->J[0] += s->constant_mass[k];
            frame->heavy = 1;
        }
        else if (i >= 0 && i < n && j >= 0 && j < n) T->pairs[T->n_pairs++] = (Pair){i, j, s->constant_mass[k]};
        else if (s->constant_row[k] >= s->n_fixed_x || s->constant_column[k] >= s->n_fixed_x) return 0;
    }
    return 1;
}

/* One field of gravity, at all points. */
static int has_one_field(const Spec *s, const struct Tree *T)
{
    for (int i = 1; i < T->n_points; i++)
        for (int c = 0; c < T->dimension; c++) {
            const real first = s->field[T->points[0].c[c]], here = s->field[T->points[i].c[c]];
            EACH_LANE if (LANE(first, w) != LANE(here, w)) return 0;
        }
    return 1;
}

/* Is the mechanism a rigid tree? */
static int is_tree(const Model *m, struct Tree *T, int *of)
{
    const Spec *s = &m->s;
    for (int i = 0; i < s->nx; i++) of[i] = -1;
    if (!find_parts(s, T, of) || !begin_tree(s, T)) return 0;
    int left = 0, found = 1;
    for (int i = 0; i < T->n_parts; i++) left += JOINT[T->parts[i].batch->kind].how != OF_A_NODE;
    while (left && found) {
        found = 0;
        for (int i = 0; i < T->n_parts; i++) {
            Part *part = &T->parts[i];
            if (part->reached || JOINT[part->batch->kind].how == OF_A_NODE) continue;
            const int status = reach(s, T, part);
            if (status < 0) return 0;
            found += part->reached = status;
        }
        left -= found;
    }
    return !left && is_whole(s, T) && has_one_field(s, T) && add_masses(s, T, of) && add_blocks(m, T);
}

/* Room for the rows of X: of the points, then of heavy frames. OK or NO_MEMORY. */
static int tree_rows(Memory *memory, struct Tree *T, int q)
{
    T->width = (q + ROW) / ROW * ROW;
    T->n_rows = T->dimension * T->n_points;
    for (int i = 0; i < T->n_frames; i++) {
        if (!T->frames[i].heavy) continue;
        T->frames[i].at_row = T->n_rows;
        T->n_rows += T->turns;
    }
    const size_t of_frames = T->n_frames * (9 + 3 + 4 + T->turns * (size_t)T->width);
    T->attitude = cleared(memory, of_frames + (2 * (size_t)T->n_rows + q + 1) * T->width, sizeof(real));
    if (!T->attitude) return NO_MEMORY;
    T->spin = T->attitude + 9 * T->n_frames;
    T->lambda = T->spin + 3 * T->n_frames;
    T->turning = T->lambda + 4 * T->n_frames;
    T->X = T->turning + (size_t)T->turns * T->n_frames * T->width;
    T->MX = T->X + (size_t)T->n_rows * T->width;
    T->A = T->MX + (size_t)T->n_rows * T->width;
    T->weights = T->A + (size_t)q * T->width;
    for (int i = 0; i < T->n_frames && T->turns == 3; i++) {
        if (T->frames[i].from >= 0) continue;
        T->lambda[4 * i] = EVERY(1.0);
        for (int c = 0; c < 3; c++) T->attitude[9 * i + 4 * c] = EVERY(1.0);
    }
    for (int i = 0; i < T->n_points; i++)
        for (int c = 0; c < T->dimension; c++) { /* of given coordinates */
            const int degree = T->points[i].degree[c];
            if (degree) T->X[(T->dimension * i + c) * T->width + degree] = EVERY(1.0);
        }
    return OK;
}

/* Find the tree that the mechanism is, if it is one: OK or NO_MEMORY. */
static int find_tree(Model *m)
{
    const Spec *s = &m->s;
    const int q = s->n_x_dynamic + s->n_e_dynamic;
    if (!m->holonomic || s->prescribed || s->n_x_kinematic || s->n_coupled || !s->n_batches) return OK;
    const int kind = s->batches[0].kind, dimension = kind < 0 ? 0 : JOINT[kind].dimension;
    if (!dimension || q > (dimension == 2 ? MOST_PLANAR : MOST_SPATIAL)) return OK;
    int n = 0, n_of_nodes = 0;
    for (int b = 0; b < s->n_batches; b++) {
        const Batch *k = &s->batches[b];
        n += k->n;
        if (k->kind >= 0 && JOINT[k->kind].how == OF_A_NODE) n_of_nodes += k->n;
    }
    Memory *memory = &m->tree_memory;
    struct Tree *T = m->tree = cleared(memory, 1, sizeof(struct Tree));
    int *of = cleared(memory, s->nx, sizeof(int));
    if (!T || !of) return NO_MEMORY;
    T->frames = cleared(memory, 2 * n, sizeof(Frame));
    T->orientations = cleared(memory, 2 * n, sizeof(Orientation));
    T->points = cleared(memory, 2 * n, sizeof(Point));
    T->arms = cleared(memory, n, sizeof(Arm));
    T->pairs = cleared(memory, 6 * n + s->n_constant, sizeof(Pair));
    T->parts = cleared(memory, n, sizeof(Part));
    T->links = cleared(memory, n - n_of_nodes, sizeof(Link));
    T->mass = cleared(memory, 6 * n, sizeof(real));
    if (!T->links || !T->frames || !T->orientations || !T->points || !T->arms || !T->pairs || !T->parts || !T->mass)
        return NO_MEMORY;
    T->dimension = dimension;
    T->turns = dimension == 2 ? 1 : 3;
    if (!is_tree(m, T, of)) { tree_end(m); return OK; }
    T->rcond = bound_of_condition(m, T);
    return tree_rows(memory, T, q);
}
