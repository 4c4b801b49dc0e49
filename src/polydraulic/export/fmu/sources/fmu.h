/*
 * What both versions of FMI share: one instance, its values, its state, derivatives.
 *
 * Everything is static, so that several FMUs can be linked into one program. The file config.h describes the variables,
 * and equations.h computes them:
 *
 *   fmu_start(v, memory)                      memory from parameters, when initialization ends
 *   fmu_outputs(v, memory)                    outputs from inputs, parameters and memory
 *   fmu_advance(v, memory, from, to)          memory through time, inputs held; returns 0 if it cannot go on
 *   fmu_partials(v, memory, partials)         partials[FMU_N_INPUTS * k + i]: output k by input i
 *   FMU_STUCK, if it is defined               why it cannot go on
 */
#ifndef FMU_H
#define FMU_H

#include <float.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "config.h"

typedef enum { FMU_PARAMETER, FMU_FIXED_PARAMETER, FMU_INPUT, FMU_OUTPUT } fmu_kind;

/* Tables of config.h: kind of every variable, its place among those of its kind, its start value. */
static const fmu_kind fmu_kinds[FMU_N_VARIABLES] = FMU_KINDS;
static const int fmu_places[FMU_N_VARIABLES] = FMU_PLACES;
static const double fmu_starts[FMU_N_VARIABLES] = FMU_STARTS;

#include "equations.h"

#ifndef FMU_STUCK
#define FMU_STUCK "the equations cannot go on"
#endif

typedef enum { FMU_INSTANTIATED, FMU_INITIALIZATION, FMU_RUNNING, FMU_TERMINATED, FMU_FAILED } fmu_mode;

/* All that a run needs to go on: this is what is copied and serialized. */
typedef struct {
    double time;
    double values[FMU_N_VARIABLES];
    double memory[FMU_N_MEMORY > 0 ? FMU_N_MEMORY : 1];
    int mode;
    int fresh; /* whether the outputs belong to the inputs */
} fmu_state;

static void fmu_reset(fmu_state *s)
{
    size_t i;
    memset(s, 0, sizeof *s); /* padding too: equal states are equal bytes */
    for (i = 0; i < FMU_N_VARIABLES; ++i) {
        s->values[i] = fmu_starts[i];
    }
    fmu_start(s->values, s->memory);
}

static void fmu_refresh(fmu_state *s)
{
    if (!s->fresh) {
        fmu_outputs(s->values, s->memory);
        s->fresh = 1;
    }
}

/* Null, or what is wrong. The reference FMU_N_VARIABLES is the time. */
static const char *fmu_get(fmu_state *s, const unsigned int refs[], size_t n, double values[])
{
    size_t i;
    for (i = 0; i < n; ++i) {
        if (refs[i] > FMU_N_VARIABLES) {
            return "unknown value reference";
        }
    }
    for (i = 0; i < n; ++i) {
        if (refs[i] == FMU_N_VARIABLES) {
            values[i] = s->time;
        } else {
            if (fmu_kinds[refs[i]] == FMU_OUTPUT) {
                fmu_refresh(s);
            }
            values[i] = s->values[refs[i]];
        }
    }
    return NULL;
}

static const char *fmu_set(fmu_state *s, const unsigned int refs[], size_t n, const double values[])
{
    size_t i;
    int parameters = 0;
    for (i = 0; i < n; ++i) {
        if (refs[i] >= FMU_N_VARIABLES) {
            return "unknown value reference";
        }
        if (fmu_kinds[refs[i]] == FMU_OUTPUT) {
            return "an output cannot be set";
        }
        if (fmu_kinds[refs[i]] == FMU_FIXED_PARAMETER && s->mode > FMU_INITIALIZATION) {
            return "a fixed parameter cannot be set after initialization";
        }
    }
    for (i = 0; i < n; ++i) {
        s->values[refs[i]] = values[i];
        parameters |= fmu_kinds[refs[i]] != FMU_INPUT;
    }
    if (parameters && s->mode <= FMU_INITIALIZATION) {
        fmu_start(s->values, s->memory);
    }
    s->fresh = 0;
    return NULL;
}

static int fmu_is_finite(double value)
{
    return value >= -DBL_MAX && value <= DBL_MAX;
}

/* Less than this two times may differ by rounding alone, four times that of the larger one. */
static double fmu_rounding(double a, double b)
{
    const double first = (a < 0.0) ? -a : a, second = (b < 0.0) ? -b : b;
    return 4.0 * DBL_EPSILON * ((first > second) ? first : second);
}

static const char *fmu_set_time(fmu_state *s, double time)
{
    if (!fmu_is_finite(time)) {
        return "the time must be a finite number";
    }
    s->time = time;
    return NULL;
}

static const char *fmu_begin(fmu_state *s, double start, int with_stop, double stop)
{
    if (with_stop && !(stop >= start)) {
        return "the stop time lies before the start time, or is not a number";
    }
    return fmu_set_time(s, start);
}

/* From where the last step ended, or from the start: a gap would be time that the equations never see. */
static const char *fmu_step(fmu_state *s, double from, double step)
{
    const double to = from + step, gap = (from < s->time) ? s->time - from : from - s->time;
    if (!(step >= 0.0 && step <= DBL_MAX)) {
        return "the communication step must be finite and not negative: nothing was done";
    }
    if (!fmu_is_finite(from) || !fmu_is_finite(to)) {
        return "a communication step must begin and end at finite times: nothing was done";
    }
    if (gap > fmu_rounding(from, s->time) + 1e-9 * step) {
        return "the communication point is not where the last step ended, or the start time: nothing was done";
    }
    if (FMU_INTERNAL_STEP > 0.0 && fmu_rounding(from, to) > 0.5 * FMU_INTERNAL_STEP) {
        return "times of this size are too coarse to count internal steps: nothing was done; start nearer to 0";
    }
    if (!fmu_advance(s->values, s->memory, from, to)) {
        s->mode = FMU_FAILED;
        return FMU_STUCK;
    }
    s->time = to;
    s->fresh = 0;
    return NULL;
}

/* Seed through the Jacobian: forwards from knowns to unknowns, or (adjoint) backwards from unknowns to knowns. */
static const char *fmu_derivative(fmu_state *s, const unsigned int unknowns[], size_t n_unknown,
    const unsigned int knowns[], size_t n_known, const double seed[], double sensitivity[], int adjoint)
{
    double partials[FMU_N_OUTPUTS * FMU_N_INPUTS > 0 ? FMU_N_OUTPUTS * FMU_N_INPUTS : 1];
    size_t k, i;
    for (k = 0; k < n_unknown; ++k) {
        if (unknowns[k] >= FMU_N_VARIABLES || fmu_kinds[unknowns[k]] != FMU_OUTPUT) {
            return "derivatives are those of outputs";
        }
    }
    for (i = 0; i < n_known; ++i) {
        if (knowns[i] >= FMU_N_VARIABLES || fmu_kinds[knowns[i]] != FMU_INPUT) {
            return "derivatives are those by inputs";
        }
    }
    fmu_partials(s->values, s->memory, partials);
    for (k = 0; k < (adjoint ? n_known : n_unknown); ++k) {
        sensitivity[k] = 0.0;
    }
    for (k = 0; k < n_unknown; ++k) {
        for (i = 0; i < n_known; ++i) {
            const double slope = partials[FMU_N_INPUTS * fmu_places[unknowns[k]] + fmu_places[knowns[i]]];
            if (adjoint) {
                sensitivity[i] += slope * seed[k];
            } else {
                sensitivity[k] += slope * seed[i];
            }
        }
    }
    return NULL;
}

#endif
