/* Questions to Python (spacar/compiled/python_callbacks.py), through addresses of functions of its stable C interface,
   so that the engine fits every version. Nothing that is raised passes through C: it is handed to `keep`, and the
   evaluation ends. */

/* Types live as long as the object. */
static void *type_of(const Python *py, void *object)
{
    void *type = py->PyObject_Type(object);
    py->Py_DecRef(type);
    return type;
}

/* Write the values of n rows of the known form, and give their sum; NAN when Python has to read them: some may have
   been written. */
static double take_rows(const Python *py, void *rows, const Row *known, int n, double *values)
{
    if (type_of(py, rows) != py->list_type || py->PyList_Size(rows) != n) return NAN;
    double total = 0.0;
    for (int k = 0; k < n; k++) {
        void *row = py->PyList_GetItem(rows, k), *type = type_of(py, row);
        const int is_tuple = type == py->tuple_type;
        if (!is_tuple && type != py->list_type) return NAN;
        void *(*const item)(void *, ptrdiff_t) = is_tuple ? py->PyTuple_GetItem : py->PyList_GetItem;
        if ((is_tuple ? py->PyTuple_Size : py->PyList_Size)(row) != 3) return NAN;
        double number[3];
        for (int c = 0; c < 3; c++) {
            void *value = item(row, c), *kind = type_of(py, value);
            if (kind != py->real_type && kind != py->numpy_real && kind != py->whole_type) return NAN;
            number[c] = py->PyFloat_AsDouble(value);
            if (number[c] == -1.0 && py->PyErr_Occurred()) { py->PyErr_Clear(); return NAN; } /* too large */
        }
        if (number[0] != known[k].first || number[1] != known[k].second) return NAN;
        values[(int)known[k].place] = number[2];
        total += number[2];
    }
    return total;
}

/* Whether time, stresses, forces were taken. */
static int is_taken(const PythonCallbacks *a, void *given)
{
    const Python *py = a->python;
    if (a->n_sigma < 0 || type_of(py, given) != py->tuple_type || py->PyTuple_Size(given) != 3) return 0;
    return isfinite(take_rows(py, py->PyTuple_GetItem(given, 1), a->rows, a->n_sigma, a->sigma)
                    + take_rows(py, py->PyTuple_GetItem(given, 2), a->rows + a->n_sigma, a->n_force, a->force));
}

/* Hand what was raised to Python, with its traceback. */
static void keep_raised(PythonCallbacks *a)
{
    const Python *py = a->python;
    void *type, *value, *traceback;
    if (!py->PyErr_ExceptionMatches(py->exception)) a->stopped = 1;
    py->PyErr_Fetch(&type, &value, &traceback);
    py->PyErr_NormalizeException(&type, &value, &traceback);
    if (value && traceback) py->PyException_SetTraceback(value, traceback);
    void *done = py->PyObject_CallFunctionObjArgs(a->keep, value, NULL);
    if (!done) py->PyErr_Clear();
    py->Py_DecRef(done);
    py->Py_DecRef(type);
    py->Py_DecRef(value);
    py->Py_DecRef(traceback);
}

/* OK, or NOT_ANSWERED: Python keeps an error, or wants to look. `batch` of a question about elements. */
static int ask(PythonCallbacks *a, int what, int batch, double t)
{
    if (a->stopped) return NOT_ANSWERED;
    const Python *py = a->python;
    if (!py) return a->back(what, batch, t) ? NOT_ANSWERED : OK;
    const int held = py->PyGILState_Ensure();
    void *of[] = {py->PyLong_FromLong(what), py->PyLong_FromLong(batch), py->PyFloat_FromDouble(t)};
    void *answer = of[0] && of[1] && of[2] ? py->PyObject_CallFunctionObjArgs(a->answer, of[0], of[1], of[2], NULL)
        : NULL;
    const int stops = answer ? py->PyObject_IsTrue(answer) : -1;
    a->within = 0;
    if (stops < 0) keep_raised(a);
    py->Py_DecRef(answer);
    for (int k = 0; k < 3; k++) py->Py_DecRef(of[k]);
    py->PyGILState_Release(held);
    return stops ? NOT_ANSWERED : OK;
}

/* The user function: OK, or NOT_ANSWERED as above. Values are zeros before. */
static int ask_stresses(PythonCallbacks *a, double t)
{
    if (!a->function) return ask(a, ASK_STRESS, 0, t);
    if (a->stopped) return NOT_ANSWERED;
    const Python *py = a->python;
    void *const *w = a->told;
    const int held = py->PyGILState_Ensure();
    void *time = py->PyFloat_FromDouble(t), *done = NULL;
    void *given = time
        ? py->PyObject_CallFunctionObjArgs(a->function, time, w[0], w[1], w[2], w[3], w[4], w[5], w[6], w[7], NULL)
        : NULL;
    a->t = t;
    a->within = !given;
    int answered = given && is_taken(a, given);
    if (given && !answered) answered = (done = py->PyObject_CallFunctionObjArgs(a->read, time, given, NULL)) != NULL;
    if (!answered) keep_raised(a);
    py->Py_DecRef(done);
    py->Py_DecRef(given);
    py->Py_DecRef(time);
    py->PyGILState_Release(held);
    return answered ? OK : NOT_ANSWERED;
}
