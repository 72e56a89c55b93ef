/* The lists behind a model: which entries of V and M there are, and where they go in the two systems. */

/* A value that no arithmetic gives: not-a-number with a payload. */
static const uint64_t UNTOUCHED = 0x7ff8dead00000001u;

static real untouched(void)
{
    double value;
    memcpy(&value, &UNTOUCHED, sizeof value);
    return EVERY(0.0) + value;
}

static int written(real value)
{
    const double first = LANE(value, 0);
    return memcmp(&first, &UNTOUCHED, sizeof first) != 0;
}

/* All entries of the matrices of a foreign batch: (rows, nxe, n) from `source` on. */
static void add_foreign(Entries *list, const Batch *k, const int *rows, int n_rows, int source)
{
    for (int r = 0; r < n_rows; r++)
        for (int j = 0; j < k->nxe; j++)
            for (int i = 0; i < k->n; i++) add(list, rows[i * n_rows + r], k->x[i * k->nxe + j], source++);
}

/* What has been written of the matrix of an element, whose `values` begin at `source`. */
static void add_written(Entries *list, const real *values, int source, const int *rows, int n_rows, const int *columns,
    int n)
{
    for (int r = 0; r < n_rows; r++)
        for (int j = 0; j < n; j++, source++) if (written(values[source])) add(list, rows[r], columns[j], source);
}

/* Pairs of entries of V whose product is an entry of V^T M_e V; their number. */
static int pairs(const Model *m, Entries *list, int source, int *first, int *second, real *weight)
{
    int n = 0;
    for (int k = 0; k < m->s.n_coupled; k++) {
        const int r = m->s.coupled_rows[k], c = m->s.coupled_columns[k];
        for (int a = m->v_start[r]; a < m->v_start[r + 1]; a++)
            for (int b = m->v_start[c]; b < m->v_start[c + 1]; b++, n++) {
                if (weight) weight[n] = m->s.coupled[k];
                if (!list) continue;
                add(list, m->v_column[a], m->v_column[b], source + n);
                first[n] = m->v_place[a];
                second[n] = m->v_place[b];
            }
    }
    return n;
}

/* MEE: where the products of V^T M_e V are; `values` grows by them. */
static int find_coupling(Model *m, int n_values)
{
    const int n = pairs(m, NULL, 0, NULL, NULL, NULL);
    if (entries_begin(&m->memory, &m->coupling, n)) return NO_MEMORY;
    if (!n) return OK;
    m->coupling_first = cleared(&m->memory, n, sizeof(int));
    m->coupling_second = cleared(&m->memory, n, sizeof(int));
    m->coupling_weight = cleared(&m->memory, n, sizeof(real));
    real *values = cleared(&m->memory, n_values + n, sizeof(real));
    if (!m->coupling_first || !m->coupling_second || !m->coupling_weight || !values) return NO_MEMORY;
    memcpy(values, m->values, sizeof(real) * n_values);
    m->values = values;
    pairs(m, &m->coupling, n_values, m->coupling_first, m->coupling_second, m->coupling_weight);
    return OK;
}

/* V and M of the elements at the reference configuration, into `values`. */
static void reference_values(Model *m)
{
    const Spec *s = &m->s;
    real xe[MAX_X], ve[MAX_X], ee[MAX_E], he[MAX_X];
    int element = 0;
    for (int b = 0; b < s->n_batches; b++) {
        const Batch *k = &s->batches[b];
        for (int i = 0; i < k->n && !k->foreign; i++) {
            const int *ix = k->x + i * k->nxe, at = element + i;
            for (int j = 0; j < k->nxe; j++) { xe[j] = s->x0[ix[j]]; ve[j] = EVERY(0.0); }
            if (k->nee) STRAIN[k->kind](xe, k->p + i * k->np, ee, m->values + m->v_offset[at]);
            if (k->inertia) INERTIA[k->kind](xe, ve, k->p + i * k->np, m->values + m->m_offset[at], he);
        }
        element += k->n;
    }
}

/* What the functions of an element write is an entry; the rest of the element matrix is structurally zero. They are
   called once with marked values in the matrices. The number of values, or NO_MEMORY. */
static int find_entries(Model *m, Memory *work, Entries *V)
{
    const Spec *s = &m->s;
    int element = 0, n_v = 0, n_m = 0;
    for (int b = 0; b < s->n_batches; b++) {
        const Batch *k = &s->batches[b];
        for (int i = 0; i < k->n; i++, element++) {
            m->v_offset[element] = n_v;
            m->m_offset[element] = n_m;
            n_v += k->nee * k->nxe;
            if (k->inertia) n_m += k->nxe * k->nxe;
        }
    }
    for (int k = 0; k < element; k++) m->m_offset[k] += n_v;
    const int at = n_v + n_m, n_values = at + s->n_constant;
    m->values = taken(&m->memory, n_values, sizeof(real));
    if (!m->values || entries_begin(work, V, n_v) || entries_begin(&m->memory, &m->mass, n_values - n_v))
        return NO_MEMORY;
    for (int k = 0; k < n_values; k++) m->values[k] = untouched();
    reference_values(m);
    element = 0;
    for (int b = 0; b < s->n_batches; b++) {
        const Batch *k = &s->batches[b];
        if (k->foreign) {
            add_foreign(V, k, k->e, k->nee, m->v_offset[element]);
            if (k->inertia) add_foreign(&m->mass, k, k->x, k->nxe, m->m_offset[element]);
            element += k->n;
            continue;
        }
        for (int i = 0; i < k->n; i++, element++) {
            const int *x = k->x + i * k->nxe;
            add_written(V, m->values, m->v_offset[element], k->e + i * k->nee, k->nee, x, k->nxe);
            if (k->inertia) add_written(&m->mass, m->values, m->m_offset[element], x, k->nxe, x, k->nxe);
        }
    }
    for (int k = 0; k < at; k++) if (!written(m->values[k])) m->values[k] = EVERY(0.0);
    for (int k = 0; k < s->n_constant; k++) {
        m->values[at + k] = s->constant_mass[k];
        add(&m->mass, s->constant_row[k], s->constant_column[k], at + k);
    }
    return n_values;
}

/* A list by rows: row r from start[r] on. */
static int sort_rows(Memory *memory, const Entries *list, int n_rows, int **start, int **column, int **place)
{
    *start = cleared(memory, n_rows + 2, sizeof(int));
    *column = taken(memory, list->n, sizeof(int));
    *place = taken(memory, list->n, sizeof(int));
    if (!*start || !*column || !*place) return NO_MEMORY;
    for (int k = 0; k < list->n; k++) (*start)[list->row[k] + 2]++;
    for (int r = 0; r < n_rows; r++) (*start)[r + 2] += (*start)[r + 1];
    for (int k = 0; k < list->n; k++) {
        const int at = (*start)[list->row[k] + 1]++;
        (*column)[at] = list->column[k];
        (*place)[at] = list->source[k];
    }
    return OK;
}

/* Whether the reduced form takes less time than the saddle-point form: its operations on vectors of ROW numbers
   against the entries of the factors of the saddle-point matrix, which are counted where its own entries leave it
   open (measured break-even, docs/performance.md). */
static int takes_reduced_form(Model *m, int q)
{
    Sparse *motion = &m->motion;
    const double worth = LANES == 1 ? 5.0 : 9.0, sure = worth * motion->entries.n;
    const double transfer = (double)((q + ROW) / ROW) * (m->position.entries.n + m->mass.n + m->coupling.n);
    const double operations = transfer + (double)m->s.nx * q * (1.0 + 0.5 * q / ROW);
    if (operations < 0.4 * sure || operations > 2.0 * sure) return operations < sure;
    return !plan(motion, m->values, 0, INFINITY)
        && operations < worth * (motion->row_at[motion->n] - motion->n);
}

/* Entries of a list at free coordinates, into the saddle-point matrix; `place` (nx): of coordinates in it, or -1. */
static void put_free(Sparse *motion, const Entries *list, const int *place)
{
    for (int k = 0; k < list->n; k++) {
        const int i = place[list->row[k]], j = place[list->column[k]];
        if (i >= 0 && j >= 0) add(&motion->entries, i, j, list->source[k]);
    }
}

/* V[E, U] of the positions, and the saddle-point matrix of the accelerations and multipliers. OK or NO_MEMORY. */
static int assemble(Model *m)
{
    const Spec *s = &m->s;
    const int n = s->n_equations, nc = s->n_position, first = s->n_fixed_x, nf = s->n_free, nr = s->n_rows;
    const int entries = m->v_start[s->ne], q = s->n_x_dynamic + s->n_e_dynamic;
    const int with_motion = !s->prescribed && !m->tree;
    Memory *memory = &m->memory;
    m->width = (q + ROW) / ROW * ROW;
    int *place = cleared(memory, s->nx, sizeof(int));
    if (!place || sparse_begin(memory, &m->position, nc, entries)
        || (!m->holonomic && sparse_begin(memory, &m->velocity, n, entries))
        || (with_motion && sparse_begin(memory, &m->motion, nf + nr, m->mass.n + m->coupling.n + 2 * entries))
        || entries_begin(memory, &m->dynamic, entries) || entries_begin(memory, &m->given, m->mass.n))
        return NO_MEMORY;
    for (int k = 0; k < m->mass.n; k++) {
        const int j = m->mass.column[k];
        const real field = s->field[j];
        int known = j >= s->x_input && j < s->x_input + s->n_x_input;
        EACH_LANE if (LANE(field, w) != 0.0) known = 1;
        if (known) add(&m->given, m->mass.row[k], j, m->mass.source[k]);
    }
    for (int i = 0; i < nc; i++)
        for (int r = s->position[i], k = m->v_start[r]; k < m->v_start[r + 1]; k++) {
            const int j = m->v_column[k] - first, d = m->v_column[k] - s->x_dynamic;
            if (j >= 0 && j < nc) add(&m->position.entries, i, j, m->v_place[k]);
            if (d >= 0 && d < s->n_x_dynamic) add(&m->dynamic, i, d, m->v_place[k]);
        }
    for (int r = 0; r < n && !m->holonomic; r++)
        for (int k = m->v_start[r]; k < m->v_start[r + 1]; k++) {
            const int j = m->v_column[k] - first, u = m->v_column[k] - s->x_kinematic;
            if (j >= 0 && j < nc) add(&m->velocity.entries, r, j, m->v_place[k]);
            if (u >= 0 && u < s->n_x_kinematic) add(&m->velocity.entries, r, nc + u, m->v_place[k]);
        }
    if (with_motion) {
        for (int i = 0; i < s->nx; i++) place[i] = -1;
        for (int i = 0; i < nf; i++) place[s->free[i]] = i;
        put_free(&m->motion, &m->mass, place);
        put_free(&m->motion, &m->coupling, place);
        for (int r = 0; r < nr; r++)
            for (int k = m->v_start[r]; k < m->v_start[r + 1]; k++) {
                const int j = place[m->v_column[k]];
                if (j < 0) continue;
                add(&m->motion.entries, nf + r, j, m->v_place[k]);
                add(&m->motion.entries, j, nf + r, m->v_place[k]);
            }
    }
    m->reduced = m->holonomic && !s->prescribed && (m->tree || takes_reduced_form(m, q));
    if (!m->reduced) return OK;
    m->position.work = cleared(memory, (size_t)nc * m->width, sizeof(real)); /* of so many right-hand sides */
    return m->position.work ? sort_rows(memory, &m->mass, s->nx, &m->m_start, &m->m_column, &m->m_place) : NO_MEMORY;
}

static void spacar_end(Model *m)
{
    if (!m) return;
    sparse_end(&m->position, &m->first[0]);
    sparse_end(&m->velocity, &m->first[1]);
    sparse_end(&m->motion, &m->first[2]);
    tree_end(m);
    Memory memory = m->memory;
    give_back(&memory);
}

/* A capsule of Python ends a model with its last reference: a `__del__` would drop the Ctrl-C that is noticed within
   it. */
static void *(*capsule_pointer)(void *capsule, const char *name);
static void spacar_capsules(void *(*pointer)(void *, const char *)) { capsule_pointer = pointer; }
static void spacar_dropped(void *capsule) { spacar_end(capsule_pointer(capsule, NULL)); }

/* A model of the arrays of `read_spec`; NULL when there is no memory. */
static Model *spacar_begin(const int *whole, real *numbers, const Foreign *const *foreign, const User *user,
    PythonCallbacks *asking)
{
    Memory memory = {0};
    Model *m = cleared(&memory, 1, sizeof(Model));
    if (!m) return NULL;
    m->memory = memory; /* which the model is in */
    const Spec *spec = &m->s;
    if (read_spec(m, whole, numbers, foreign)) { spacar_end(m); return NULL; }
    m->s.user = user;
    m->s.asking = asking;
    const int nx = spec->nx, ne = spec->ne;
    int elements = 0;
    for (int b = 0; b < spec->n_batches; b++) elements += spec->batches[b].n;
    m->v_offset = cleared(&m->memory, elements, sizeof(int));
    m->m_offset = cleared(&m->memory, elements, sizeof(int));
    m->holonomic = spec->n_position == spec->n_equations && !spec->n_e_kinematic;
    for (int i = 0; i < spec->n_position; i++) if (spec->position[i] != i) m->holonomic = 0;
    Memory work = {0};
    Entries V = {0};
    const int n_values = m->v_offset && m->m_offset ? find_entries(m, &work, &V) : NO_MEMORY;
    int status = n_values < 0 ? NO_MEMORY : sort_rows(&m->memory, &V, ne, &m->v_start, &m->v_column, &m->v_place);
    if (!status) status = find_coupling(m, n_values);
    give_back(&work);
    if (!status) status = find_tree(m);
    if (!status) status = assemble(m);
    const int q = spec->n_x_dynamic + spec->n_e_dynamic;
    real *vector = status ? NULL
        : cleared(&m->memory, 11 * (nx + ne) + 2 * nx + 2 * (3 * (STATES - 1) * nx + 3 * STATES * q), sizeof(real));
    if (!vector) { spacar_end(m); return NULL; }
    real **vectors[] = {&m->h, &m->branch, &m->next_e, &m->given_ed, &m->given_edd};
    for (int k = 0; k < 5; k++, vector += ne) *vectors[k] = vector;
    real **coordinates[] =
        {&m->convected, &m->applied, &m->force, &m->next_x, &m->next_xd, &m->next_xdd, &m->factored_x};
    for (int k = 0; k < 7; k++, vector += nx) *coordinates[k] = vector;
    m->b = vector; /* of two vectors of the degrees of freedom too, which may be all coordinates */
    m->stage = m->b + 2 * (nx + ne);
    m->piece = m->stage + 2 * (nx + ne);
    vector = m->piece + 2 * (nx + ne);
    for (int k = 0; k < 2; k++) {
        for (int l = 0; l < STATES; l++, vector += 3 * q) m->traces[k].degrees[l] = vector;
        for (int l = 0; l < STATES - 1; l++, vector += 3 * nx) m->traces[k].before[l] = vector;
    }
    if (m->reduced) {
        m->transfer = cleared(&m->memory, (2 * nx + q) * m->width, sizeof(real));
        if (!m->transfer) { spacar_end(m); return NULL; }
        m->weighted = m->transfer + nx * m->width;
        m->small = m->weighted + nx * m->width;
    }
    return m;
}

/* Does a factorization at the reference configuration take more than MOST multiplications? Then SuperLU, which orders
   condensed matrices and multiplies blocks, takes less time (condensed.py). Otherwise the orders stay. */
static int spacar_too_large(Model *m)
{
    enum { MOST = 20000000, FEW = 400 }; /* FEW unknowns never take so many */
    Sparse *of[] = {&m->position, &m->motion};
    for (int k = 0; k < (m->reduced ? 1 : 2) && !m->tree; k++)
        if (of[k]->n > FEW && !of[k]->planned && plan(of[k], m->values, 0, MOST) == MUCH_WORK) return 1;
    return 0;
}

/* Other numbers of the same cases stand in the array of `read_spec`, of a model without foreign batches. GRAVITY is
   the same, as the lists depend on where it acts. Nothing is left of the states that were evaluated with the old
   numbers but the orders of pivots, which are those of the first call: rounding does not depend on the numbers in
   between. */
static void spacar_renew(Model *m)
{
    const Spec *s = &m->s;
    take_parameters(m);
    reference_values(m);
    for (int k = 0; k < s->n_constant; k++)
        m->values[m->mass.source[m->mass.n - s->n_constant + k]] = s->constant_mass[k];
    pairs(m, NULL, 0, NULL, NULL, m->coupling_weight);
    first_order(&m->position, &m->first[0]);
    first_order(&m->velocity, &m->first[1]);
    first_order(&m->motion, &m->first[2]);
    m->factored = 0;
    m->transfer_of = NULL;
    m->evaluations++;
    m->of_tree = m->matrices_behind = m->factors_behind = 0;
    for (int k = 0; k < 2; k++) { m->traces[k].of = NULL; m->traces[k].n = 0; }
    tree_end(m);
    if (find_tree(m)) tree_end(m); /* no memory: the general equations do */
}
