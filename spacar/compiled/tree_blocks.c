/* A rigid tree (rigid_tree.c), and V[E, U] of it by blocks: one for each element and what it carries, and its
   condition.

   Deformations do not change with a rotation of the whole element, and a rigid one has none: how they depend on the
   motion of its outer end, in the axes of its frame, is a constant of the reference configuration (for a hinge: of
   the frame at p). The matrix is block triangular in the order from the ground outwards, so that its determinant is
   constant too (theory-system.md section 13). */
/* Degrees of freedom up to which it pays against the saddle-point form: the rows of X are full (docs/performance.md,
   rigid trees). */
enum { MOST_PLANAR = 32, MOST_SPATIAL = 64 };
enum { APART, RIGID, TURNING, OF_A_NODE };
enum { AT_P, TURN_P, AT_Q, TURN_Q };
/* `end`: the first of its coordinates; -1: no such node */
typedef struct { signed char how, dimension, end[4]; } Joint;
static const Joint JOINT[N_KINDS] = {
    [PLBEAM] = {RIGID, 2, {0, 2, 3, 5}}, [PLBEAM_ANGLE] = {RIGID, 2, {0, 2, 3, 5}},
        [PLPINBOD] = {RIGID, 2, {0, 2, 3, -1}},
    [BEAM] = {RIGID, 3, {0, 3, 7, 10}}, [BEAM_ANGLE] = {RIGID, 3, {0, 3, 7, 10}}, [PINBODY] = {RIGID, 3, {0, 3, 7, -1}},
    [PLTOR] = {TURNING, 2, {-1, 0, -1, 1}}, [HINGE] = {TURNING, 3, {-1, 0, -1, 4}},
    [NORMALIZATION] = {OF_A_NODE, 3, {-1, 0, -1, -1}}, [BODY] = {OF_A_NODE, 3, {-1, 0, -1, -1}},
};

typedef struct {
    /* frame it turns against, or -1; row of e that is the angle; its column, 0: none; -1 or the given angle */
    int from, row, degree, place;
    double sign;
    real axis[3], angle;          /* the angle at the reference (planar) */
    real J[6];                    /* xx, xy, xz, yy, yz, zz; planar: one number */
    int heavy, at_row;            /* J is not 0; then its first row of X */
} Frame;
/* frame -1: not reached; shift: angle less that of the frame (planar) */
typedef struct { int c[4], n, frame; real shift; } Orientation;
/* reached: 1 given, 2 by an arm; columns of its coordinates */
typedef struct { int c[3], reached, degree[3]; } Point;
typedef struct { int p, q, frame; real r[3]; } Arm;
typedef struct { int row, column; real mass; } Pair;           /* an entry of M off its diagonal */
typedef struct { const Batch *batch; int i, node[4], reached; } Part; /* an element, and the nodes at its ends */
enum { MOST_LINKED = 6 };
/* An element and what it carries: point and orientation at its outer end, or -1. L Q, Q orthogonal: how its n
   deformations depend on their motion in the axes of a frame, a constant. */
typedef struct {
    int part, point, node, frame, n;
    real L[MOST_LINKED][MOST_LINKED], Q[MOST_LINKED][MOST_LINKED], inverse[MOST_LINKED]; /* of the diagonal of L */
} Link;

struct Tree {
    int dimension, turns;         /* of a point: 2 or 3; rows of an angular velocity: 1 or 3 */
    int n_frames, n_orientations, n_points, n_arms, n_pairs, n_parts, n_links, n_rows, width;
    Frame *frames; Orientation *orientations; Point *points; Arm *arms; Pair *pairs; Part *parts;
    Link *links;                  /* in the order from the ground outwards */
    double rcond;                 /* at most the reciprocal condition of V[E, U], wherever the tree is */
    real *attitude, *spin;        /* of the frames: R (9), or cos and sin; angular velocity (3), or (1) */
    real *lambda;                 /* (4) Euler parameters, or the angle */
    real *turning;                /* rows (turns, width) of the frames, as X */
    real *mass;                   /* diagonal of M in the rows of points */
    real *X, *MX, *A;             /* (n_rows, width) of points, then of heavy frames; M X less the forces; (q, width) */
    real *weights;                /* (width) of the columns of X: 1, accelerations of the degrees of freedom, zeros */
};

/* L and Q of the links from V at the reference configuration (Gram-Schmidt on its rows, twice: as exact as
   Householder's reflections, L. Giraud and others, docs/reference/bibliography.md). 0: an element does not hold what
   it carries. */
static int add_blocks(const Model *m, struct Tree *T)
{
    for (int l = 0; l < T->n_links; l++) {
        Link *link = &T->links[l];
        const Part *part = &T->parts[link->part];
        const Batch *k = part->batch;
        const Joint *joint = &JOINT[k->kind];
        const real *V = m->values + m->v_offset[link->part];
        int column[MOST_LINKED], n = 0, turning;
        for (int c = 0; c < T->dimension && link->point >= 0; c++)
            column[n++] = joint->end[link->point == part->node[AT_Q] ? AT_Q : AT_P] + c;
        turning = n;
        for (int c = 0; c < T->turns && link->node >= 0; c++)
            column[n++] = joint->end[link->node == part->node[TURN_Q] ? TURN_Q : TURN_P] + c + (T->turns == 3);
        link->n = n;
        if (n != k->nee) return 0;
        for (int r = 0; r < n; r++) {
            real *row = link->Q[r], size = EVERY(0.0);
            for (int c = 0; c < n; c++) /* lambda' = (0, w)/2 */
                row[c] = V[r * k->nxe + column[c]] * (c >= turning && T->turns == 3 ? 0.5 : 1.0);
            for (int i = 0; i < 2 * r; i++) {
                const int s = i % r;
                real along = EVERY(0.0);
                for (int c = 0; c < n; c++) along += row[c] * link->Q[s][c];
                for (int c = 0; c < n; c++) row[c] -= along * link->Q[s][c];
                link->L[r][s] += along;
            }
            for (int c = 0; c < n; c++) size += row[c] * row[c];
            EACH_LANE if (!(LANE(size, w) > 0.0)) return 0;
            link->L[r][r] = lanes_sqrt(size);
            link->inverse[r] = 1.0 / link->L[r][r];
            for (int c = 0; c < n; c++) row[c] *= link->inverse[r];
        }
    }
    return 1;
}

/* Length of a vector of n numbers. */
static real norm_of(const real *v, int n)
{
    real sum = EVERY(0.0);
    for (int i = 0; i < n; i++) sum += v[i] * v[i];
    return lanes_sqrt(sum);
}

/* How far the coordinates go altogether, in their sizes, for a unit of deformation r of a link: what is beyond moves
   with its end and turns about it, no point farther away than `reach`, the length of all arms. A vector (n) has a
   1-norm of sqrt(n) times its length at most. */
static real way_of(const struct Tree *T, const Link *link, int r, real reach, double shortest)
{
    const int n = link->n, d = link->point >= 0 ? T->dimension : 0;
    real z[MOST_LINKED], motion[MOST_LINKED] = {0};
    for (int i = 0; i < n; i++) { /* L Q motion = unit */
        z[i] = EVERY(i == r ? 1.0 : 0.0);
        for (int k = 0; k < i; k++) z[i] -= link->L[i][k] * z[k];
        z[i] *= link->inverse[i];
        for (int c = 0; c < n; c++) motion[c] += link->Q[i][c] * z[i];
    }
    const real moved = norm_of(motion, d), turned = norm_of(motion + d, n - d);
    return T->n_points * sqrt(T->dimension) * (moved + reach * turned) / shortest + T->n_orientations * turned;
}

/* Reciprocal condition of diag(1/e_scale) V[E, U] diag(scale) in the 1-norm, or less, of all configurations and
   lanes. Blocks of V that belong to a node keep the lengths of their rows when it turns. A unit of a normalization
   makes Euler parameters longer by a half, which the deformations at their node undo. */
static double bound_of_condition(Model *m, const struct Tree *T)
{
    const Spec *s = &m->s;
    const int d = T->dimension, turns = d == 2 ? 1 : 4;
    real norm = EVERY(0.0), inverse = EVERY(0.0), reach = EVERY(0.0);
    real *column = cleared(&m->tree_memory, 2 * (T->n_points + T->n_orientations), sizeof(real)),
        *longer = column + T->n_points + T->n_orientations;
    if (!column) return 0.0;
    double shortest = INFINITY, widest = 0.0;
    for (int i = 0; i < T->n_arms; i++) reach += norm_of(T->arms[i].r, d);
    for (int i = s->n_fixed_x; i < s->n_fixed_x + s->n_position; i++) {
        shortest = fmin(shortest, s->scale[i]);
        widest = fmax(widest, s->scale[i]);
    }
    for (int l = 0; l < T->n_links; l++) {
        const Link *link = &T->links[l];
        const Part *part = &T->parts[link->part];
        const Batch *k = part->batch;
        for (int r = 0; r < k->nee; r++) {
            const real *row = m->values + m->v_offset[link->part] + r * k->nxe;
            const double size = s->e_scale[k->e[part->i * k->nee + r]];
            const real way = way_of(T, link, r, reach, shortest);
            inverse = lanes_larger(inverse, way * size);
            for (int j = 0; j < 4; j++) {
                const int first = JOINT[k->kind].end[j], turning = j == TURN_P || j == TURN_Q, node = part->node[j];
                if (first < 0) continue;
                column[turning ? T->n_points + node : node] += norm_of(row + first, turning ? turns : d) / size;
                if (turning && turns == 4) longer[node] += 0.5 * lanes_larger(EVERY(0.0), row[first]) * way;
            }
        }
    }
    for (int p = 0; p < T->n_parts; p++) {
        const Part *part = &T->parts[p];
        if (part->batch->kind != NORMALIZATION) continue;
        const double size = s->e_scale[part->batch->e[part->i]];
        column[T->n_points + part->node[TURN_P]] += 2.0 / size;
        inverse = lanes_larger(inverse, size * (longer[part->node[TURN_P]] + 1.0 / shortest));
    }
    for (int i = 0; i < T->n_points + T->n_orientations; i++) norm = lanes_larger(norm, column[i] * widest);
    const double bound = 1.0 / largest_lane(norm * inverse);
    return bound > 0.0 ? bound : 0.0;
}
