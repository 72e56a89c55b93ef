/* Rigid trees: mechanisms that open out from the ground without loops, through rigid elements, hinges and given coordinates.
   Positions, transfer functions and convective accelerations are known there without equations (docs/theory.md, "Rigid trees").

   Frames are orientations: fixed, the given angle of a planar node, or turned against another frame by the first deformation of a
   hinge about its axis a. Arms carry points, x_q = x_p + d with d = R r of a frame, so that outwards, one after the other,
       w_q = w_p + a e',   alpha_q = alpha_p + a e'' + w_p x a e',   v_q = v_p + w x d,   a_q = a_p + alpha x d + w x (w x d).
   The first column of all rows is the acceleration without the degrees of freedom, less gravity; the others are the transfer
   functions, for which the same holds without the terms of velocities. Inertia of a rigid element is that of masses at its ends,
       T = (w_pp v_p.v_p + 2 w_pq v_p.v_q + w_qq v_q.v_q)/2 + w.J w/2,
   with mass w_pp + 2 w_pq + w_qq, first moment (w_pq + w_qq) d and second moments w_qq (d.d I - d d^T) + J about p; a rod has J = 0.
   The equations of motion are those of the reduced form. */
enum { APART, RIGID, TURNING, OF_A_NODE };
typedef struct { signed char how, p, turn_p, q, turn_q; } Ends; /* first coordinates of the nodes in those of the element; -1: none */
static const Ends ENDS[N_KINDS] = {
    [PLBEAM] = {RIGID, 0, 2, 3, 5}, [PLBEAM_ANGLE] = {RIGID, 0, 2, 3, 5}, [PLPINBOD] = {RIGID, 0, 2, 3, -1},
    [BEAM] = {RIGID, 0, 3, 7, 10}, [BEAM_ANGLE] = {RIGID, 0, 3, 7, 10}, [PINBODY] = {RIGID, 0, 3, 7, -1},
    [PLTOR] = {TURNING, -1, 0, -1, 1}, [HINGE] = {TURNING, -1, 0, -1, 4},
    [NORMALIZATION] = {OF_A_NODE, -1, 0, -1, -1}, [BODY] = {OF_A_NODE, -1, 0, -1, -1},
};

typedef struct {
    int from, row, degree, place; /* frame against which it turns, or -1; row of e that is the angle; its column, 0: none; or the given angle */
    double sign;
    real axis[3], angle;          /* the angle at the reference (planar) */
    real J[6];                    /* xx, xy, xz, yy, yz, zz; or one number */
    int heavy;                    /* row of X that is its turning, or -1: J = 0 */
} Turned;
typedef struct { int c[4], frame; real shift; } Orientation; /* its coordinates; frame -1: not reached; angle less that of the frame */
typedef struct { int c[3], reached; real mass; } Point;
typedef struct { int p, q, frame; real r[3]; } Arm;
typedef struct { int p, q; real mass; } Pair;

struct Tree {
    int planar, width, n_rows, n_frames, n_orientations, n_points, n_arms, n_pairs;
    Turned *frames; Orientation *orientations; Point *points; Arm *arms; Pair *pairs;
    real *lambda, *R, *spin;      /* of the frames: parameters (4) or the angle, matrix (9) or cos and sin, angular velocity (3) or (1) */
    real *turning;                /* rows of the angular accelerations of the frames (3 or 1 each, width) */
    real *X, *MX, *A;             /* rows (n_rows, width): points, then heavy frames; M X less the forces; A (q, width) */
};

static void tree_end(Tree *T)
{
    if (!T) return;
    free(T->frames); free(T->orientations); free(T->points); free(T->arms); free(T->pairs);
    free(T->lambda);
    free(T);
}

static int is_calculable(const Spec *s, int i) { return i >= s->n_fixed_x && i < s->n_fixed_x + s->n_position; }
static int is_given(const Spec *s, const int *c, int n)
{
    int given = 1;
    for (int k = 0; k < n; k++) given &= !is_calculable(s, c[k]);
    return given;
}

/* a is b, but for rounding of numbers of that size, in all lanes. */
static int same(real a, real b, real size)
{
    const double few = 64.0 * DBL_EPSILON;
    EACH_LANE if (!(fabs(LANE(a, w) - LANE(b, w)) <= few * fabs(LANE(size, w)))) return 0;
    return 1;
}

/* The point, or the orientation, with these coordinates; a new one when it is not there. `of` (nx): which is at a coordinate. */
static int point_at(Tree *T, int *of, const int *c)
{
    if (of[c[0]] < 0) {
        Point *point = &T->points[of[c[0]] = T->n_points++];
        memcpy(point->c, c, sizeof(int) * (T->planar ? 2 : 3));
    }
    return of[c[0]];
}
static int orientation_at(Tree *T, int *of, const int *c)
{
    if (of[c[0]] < 0) {
        Orientation *node = &T->orientations[of[c[0]] = T->n_orientations++];
        memcpy(node->c, c, sizeof(int) * (T->planar ? 1 : 4));
        node->frame = -1;
    }
    return of[c[0]];
}

static Turned *new_frame(Tree *T, Orientation *node)
{
    Turned *frame = &T->frames[node->frame = T->n_frames++];
    frame->from = frame->place = -1;
    frame->heavy = -1;
    return frame;
}

/* The rows of an element are fixed, but for the first one of a hinge, which may be given or free. */
static int has_rows(const Spec *s, const Batch *k, int i, int how)
{
    for (int r = how == TURNING; r < k->nee; r++) if (k->e[i * k->nee + r] >= s->e_input) return 0;
    return how != TURNING || k->e[i * k->nee] < s->n_equations;
}

/* Frames, arms and points outwards from what is given. Whether all is reached, and once. */
static int reach(const Spec *s, Tree *T, const int *node_of)
{
    const int turns = T->planar ? 1 : 4, dimension = T->planar ? 2 : 3, a = s->n_x_dynamic;
    int left = 0, found = 1, n_coordinates = 0;
    for (int i = 0; i < T->n_points; i++) T->points[i].reached = is_given(s, T->points[i].c, dimension);
    for (int i = 0; i < T->n_orientations; i++) {
        Orientation *node = &T->orientations[i];
        if (!is_given(s, node->c, turns)) continue;
        Turned *frame = new_frame(T, node);
        if (T->planar) {
            const int at = node->c[0], k = at - s->x_dynamic;
            frame->place = at;
            frame->degree = k >= 0 && k < a ? 1 + k : 0;
            frame->angle = s->x0[at];
        }
        else for (int k = 0; k < 4; k++) if (node->c[k] >= s->n_fixed_x) return 0;
    }
    int *done = cleared(node_of[-1] + 1, sizeof(int));
    if (!done) return 0;
    do {
        const int *end = node_of;
        int element = 0;
        found = left = 0;
        for (int b = 0; b < s->n_batches; b++) {
            const Batch *k = &s->batches[b];
            const int how = ENDS[k->kind].how;
            if (how == OF_A_NODE) continue;
            for (int i = 0; i < k->n; i++, element++, end += 4) {
                if (done[element]) continue;
                Orientation *p = &T->orientations[end[1]], *q = end[3] < 0 ? NULL : &T->orientations[end[3]];
                const int of_p = p->frame >= 0, of_q = q && q->frame >= 0;
                if (of_p && of_q) { free(done); return 0; }
                if (how == TURNING) {
                    left++;
                    if (!of_p && !of_q) continue;
                    Orientation *known = of_p ? p : q, *next = of_p ? q : p;
                    Turned *frame = new_frame(T, next);
                    const int row = frame->row = k->e[i * k->nee], degree = row - s->e_dynamic;
                    frame->from = known->frame;
                    frame->degree = degree >= 0 && degree < s->n_e_dynamic ? 1 + a + degree : 0;
                    frame->sign = of_p ? 1.0 : -1.0;
                    frame->angle = s->x0[next->c[0]];
                    for (int c = 0; c < 3 && !T->planar; c++) frame->axis[c] = k->p[i * k->np + c];
                }
                else {
                    Point *first = &T->points[end[0]], *last = &T->points[end[2]];
                    if (first->reached && last->reached) { free(done); return 0; }
                    left++;
                    if (!(of_p || of_q) || !(first->reached || last->reached)) continue;
                    const int outwards = first->reached;
                    Orientation *known = of_p ? p : q, *next = of_p ? q : p;
                    if (next) {
                        next->frame = known->frame;
                        next->shift = s->x0[next->c[0]] - T->frames[known->frame].angle;
                    }
                    Arm *arm = &T->arms[T->n_arms++];
                    arm->p = outwards ? end[0] : end[2];
                    arm->q = outwards ? end[2] : end[0];
                    arm->frame = known->frame;
                    for (int c = 0; c < dimension; c++)
                        arm->r[c] = s->x0[T->points[arm->q].c[c]] - s->x0[T->points[arm->p].c[c]];
                    T->points[arm->q].reached = 2;
                }
                left--;
                found = done[element] = 1;
            }
        }
    } while (left && found);
    free(done);
    if (left) return 0;
    for (int i = 0; i < T->n_points; i++) {
        if (T->points[i].reached == 2)
            for (int c = 0; c < dimension; c++) n_coordinates += is_calculable(s, T->points[i].c[c]) ? 1 : s->nx;
        else for (int c = 0; c < dimension; c++) n_coordinates += T->points[i].c[c] >= s->x_dynamic && T->points[i].c[c] < s->x_dynamic + a;
    }
    for (int i = 0; i < T->n_orientations; i++) {
        const Orientation *node = &T->orientations[i];
        if (node->frame < 0) return 0;
        for (int c = 0; c < turns; c++) {
            if (!T->planar) {
                const real one = EVERY(c == 0 ? 1.0 : 0.0);
                EACH_LANE if (LANE(s->x0[node->c[c]], w) != LANE(one, w)) return 0;
            }
            n_coordinates += is_calculable(s, node->c[c]) || (node->c[c] >= s->x_dynamic && node->c[c] < s->x_dynamic + a);
        }
    }
    return n_coordinates == s->n_position + a;
}
