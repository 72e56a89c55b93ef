/* What Python asks of the last evaluated state: V, its determinant and condition, the reduced mass matrix. */

/* The entries of V: rows, columns and values, each with room for all of them (n); their number. */
static int spacar_gradient(Model *m, int *row, int *column, real *value)
{
    catch_up_matrices(m);
    for (int r = 0; r < m->s.ne; r++)
        for (int k = m->v_start[r]; k < m->v_start[r + 1]; k++) {
            row[k] = r;
            column[k] = m->v_column[k];
            value[k] = m->values[m->v_place[k]];
        }
    return m->v_start[m->s.ne];
}

/* Of the inverse of the matrix of the velocities at the last evaluated state: mantissa 2^exponent. */
static void spacar_determinant(Model *m, double *mantissa, double *exponent)
{
    catch_up(m);
    determinant(of_rates(m), mantissa, exponent);
}

/* A bound from below for the reciprocal condition of the matrix of the velocities at all states, 0: unknown. */
static double spacar_rcond_everywhere(const Model *m) { return m->tree ? m->tree->rcond : 0.0; }

/* The coordinate of an unknown of the velocities; their equations are the first deformations. */
static int unknown(const Model *m, int j)
{
    const int nc = m->s.n_position;
    return j < nc ? m->s.n_fixed_x + j : m->s.x_kinematic + j - nc;
}

/* Norm of the columns of diag(1/e_scale) A diag(scale), and a bound for that of its inverse, A the matrix of the
   velocities at the last evaluated state. |A^-1| is not larger than that of factors whose entries are their sizes,
   negative off the diagonal (N. Higham, "Accuracy and Stability of Numerical Algorithms", 2002, section 8.3): one
   transposed solution. */
static real norm_of_rates(Model *m, real *of_inverse)
{
    const Sparse *s = of_rates(m);
    const int n = s->n;
    real norm = EVERY(0.0), *sum = m->b, *y = s->work, zero = EVERY(0.0);
    memset(sum, 0, sizeof(real) * n);
    for (int k = 0; k < s->entries.n; k++)
        sum[s->entries.column[k]] +=
            lanes_larger(zero, m->values[s->entries.source[k]] / m->s.e_scale[s->entries.row[k]]);
    for (int j = 0; j < n; j++) norm = lanes_larger(norm, sum[j] * m->s.scale[unknown(m, j)]);
    *of_inverse = zero;
    for (int k = 0; k < n; k++) y[k] = EVERY(1.0 / m->s.scale[unknown(m, s->column_order[k])]);
    for (int k = 0; k < n; k++) {
        y[k] *= lanes_larger(zero, s->inverse[k]);
        for (int u = s->upper_at[k]; u < s->row_at[k + 1]; u++)
            y[s->factor_column[u]] += lanes_larger(zero, s->factors[u]) * y[k];
    }
    for (int k = n - 1; k >= 0; k--) {
        for (int l = s->row_at[k]; l < s->upper_at[k] - 1; l++)
            y[s->factor_column[l]] += lanes_larger(zero, s->factors[l]) * y[k];
        const int i = s->row_order[k];
        *of_inverse = lanes_larger(*of_inverse, y[k] * (s->weight[i] * m->s.e_scale[i]));
    }
    return norm;
}

/* Reciprocal condition of diag(1/e_scale) A diag(scale) in the 1-norm, A the matrix of the velocities at the last
   evaluated state, the smallest of the lanes: a bound from below where that is more than `enough`; else itself, from
   n solutions, or 0 when there are more than `most` unknowns. */
static double spacar_rcond(Model *m, double enough, int most)
{
    const Sparse *s = of_rates(m);
    const int n = s->n;
    if (!n) return 1.0;
    if (m->tree && m->tree->rcond > enough) return m->tree->rcond;
    if (catch_up(m)) return 0.0;
    real inverse;
    const real norm = norm_of_rates(m, &inverse);
    const double bound = 1.0 / largest_lane(norm * inverse);
    if (bound > enough) return bound;
    if (n > most) return 0.0;
    inverse = EVERY(0.0);
    for (int j = 0; j < n; j++) {
        memset(m->b, 0, sizeof(real) * n);
        m->b[j] = EVERY(m->s.e_scale[j]);
        solve(s, m->b, m->b);
        real sum = EVERY(0.0);
        for (int i = 0; i < n; i++) sum += lanes_larger(EVERY(0.0), m->b[i] / m->s.scale[unknown(m, i)]);
        inverse = lanes_larger(inverse, sum);
    }
    return 1.0 / largest_lane(norm * inverse);
}

/* The reduced mass matrix (q, q) of the degrees of freedom at the last evaluated state: from the factors of the
   reduced form, or W^T M W with the motions W of each degree of freedom alone. 0 when there is none, or no memory. */
static int spacar_reduced_mass(Model *m, real *out)
{
    const Spec *s = &m->s;
    const int nx = s->nx, a = s->n_x_dynamic, q = a + s->n_e_dynamic;
    const real *A = m->of_tree ? m->tree->A : m->reduced && m->transfer_of ? m->small : NULL;
    if (A) {
        const int width = m->of_tree ? m->tree->width : m->width;
        for (int i = 0; i < q; i++)
            for (int j = 0; j <= i; j++) {
                real sum = A[i * width + 1 + j];
                for (int k = i + 1; k < q; k++) {
                    const real *row = A + k * width + 1;
                    sum += row[i] * row[j] / row[k];
                }
                out[i * q + j] = out[j * q + i] = sum;
            }
        return 1;
    }
    if (s->prescribed) return 0;
    Memory work = {0};
    real *W = cleared(&work, (size_t)nx * q, sizeof(real)), *e_rate = m->branch, *force = m->force;
    if (!W) return 0;
    for (int c = 0; c < q; c++) {
        real *w = W + (size_t)c * nx;
        memset(e_rate, 0, sizeof(real) * s->ne);
        if (c < a) w[s->x_dynamic + c] = EVERY(1.0);
        else e_rate[s->e_dynamic + c - a] = EVERY(1.0);
        dependent(m, w, e_rate, NULL);
        memset(force, 0, sizeof(real) * nx);
        for (int k = 0; k < m->mass.n; k++)
            force[m->mass.row[k]] += m->values[m->mass.source[k]] * w[m->mass.column[k]];
        for (int k = 0; k < m->coupling.n; k++)
            force[m->coupling.row[k]] += m->values[m->coupling.source[k]] * w[m->coupling.column[k]];
        for (int d = 0; d <= c; d++) {
            real sum = EVERY(0.0);
            for (int i = 0; i < nx; i++) sum += W[(size_t)d * nx + i] * force[i];
            out[c * q + d] = out[d * q + c] = sum;
        }
    }
    give_back(&work);
    return 1;
}
