/* What the library shows: the builds of the engine that this processor can run, chosen when it is loaded.

   On x86-64 there are builds for all processors, AVX2 with FMA (level 3) and AVX-512 (level 4), whose vectors hold 2, 4
   and 8 doubles: as many cases are evaluated at a time. A single case gains nothing from level 4. */
#if defined(_WIN32)
#define SHOWN __declspec(dllexport)
#else
#define SHOWN __attribute__((visibility("default")))
#endif

extern const void *const any_1[], *const any_2[], *const any_elements[];
#ifdef LEVELS
extern const void *const v3_1[], *const v3_4[], *const v4_8[], *const v3_elements[];
#endif

typedef struct { const char *name; int lanes; const void *const *one, *const *several, *const *elements; } Level;

static Level found(void)
{
#ifdef LEVELS
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi")
        && __builtin_cpu_supports("bmi2")) {
        if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw")
            && __builtin_cpu_supports("avx512cd")
            && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
            return (Level){ "x86-64-v4", 8, v3_1, v4_8, v3_elements };
        return (Level){ "x86-64-v3", 4, v3_1, v3_4, v3_elements };
    }
    return (Level){ "x86-64", 2, any_1, any_2, any_elements };
#else
    return (Level){ "basic", 2, any_1, any_2, any_elements };
#endif
}

/* Of the C text from which the library was built. */
SHOWN const char *spacar_source(void) { return SOURCE; }

/* The level of this processor. */
SHOWN const char *spacar_level(void) { return found().name; }

/* How many cases the engine for several takes at a time. */
SHOWN int spacar_lanes(void) { return found().lanes; }

/* The functions for one case, or for as many as `spacar_lanes`. */
SHOWN const void *const *spacar_functions(int lanes) { return lanes == 1 ? found().one : found().several; }

/* The functions of batches of elements alone. */
SHOWN const void *const *spacar_element_functions(void) { return found().elements; }
