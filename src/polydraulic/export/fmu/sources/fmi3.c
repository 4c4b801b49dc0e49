/* FMI 3.0, model exchange and co-simulation. To build a shared library, define FMI3_OVERRIDE_FUNCTION_PREFIX. */
#include "config.h"

#ifndef FMI3_FUNCTION_PREFIX
#define FMI3_FUNCTION_PREFIX FMU_PREFIX
#endif
#include "fmi3Functions.h"

#include "fmu.h"

typedef struct {
    fmu_state state;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
    fmi3Boolean steps; /* whether this is an instance for co-simulation */
} fmu_instance;

/* Errors are told even if the importer has not asked for logs: nothing fails without a word. */
static fmi3Status fmu_failed(const fmu_instance *c, const char *message)
{
    if (c->log) {
        c->log(c->environment, fmi3Error, "logStatusError", message);
    }
    return fmi3Error;
}

static fmi3Status fmu_done(const fmu_instance *c, const char *message)
{
    return message ? fmu_failed(c, message) : fmi3OK;
}

static fmi3Status fmu_none(const fmu_instance *c, size_t n, const char *message)
{
    return n == 0 ? fmi3OK : fmu_failed(c, message);
}

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t n, const fmi3String categories[])
{
    (void)c;
    (void)on; /* there is nothing to log but errors, which are always told */
    (void)n;
    (void)categories;
    return fmi3OK;
}

static fmu_instance *fmu_instantiate(
    fmi3String token, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3Boolean steps)
{
    fmu_instance *c;
    if (!token || strcmp(token, FMU_TOKEN) != 0 || (!steps && !FMU_MODEL_EXCHANGE)) {
        if (log) {
            log(environment, fmi3Error, "logStatusError", "wrong instantiation token or type of FMU");
        }
        return NULL;
    }
    c = calloc(1, sizeof *c);
    if (c) {
        c->environment = environment;
        c->log = log;
        c->steps = steps;
        fmu_reset(&c->state);
    }
    return c;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log)
{
    (void)name;
    (void)resources;
    (void)visible;
    (void)logging;
    return fmu_instantiate(token, environment, log, fmi3False);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early, const fmi3ValueReference required[], size_t n_required,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update)
{
    (void)name;
    (void)resources;
    (void)visible;
    (void)logging;
    (void)events;
    (void)early;
    (void)required;
    (void)n_required;
    (void)update;
    return fmu_instantiate(token, environment, log, fmi3True);
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
    fmi3Boolean visible, fmi3Boolean logging, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
    fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock)
{
    (void)name;
    (void)token;
    (void)resources;
    (void)visible;
    (void)logging;
    (void)update;
    (void)lock;
    (void)unlock;
    if (log) {
        log(environment, fmi3Error, "logStatusError", "there is no scheduled execution");
    }
    return NULL;
}

void fmi3FreeInstance(fmi3Instance c) { free(c); }

static fmi3Status fmu_enter(fmi3Instance instance, int from, int to)
{
    fmu_instance *c = instance;
    if (c->state.mode != from) {
        return fmu_failed(c, "this function may not be called now");
    }
    c->state.mode = to;
    return fmi3OK;
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean with_tolerance, fmi3Float64 tolerance,
    fmi3Float64 start, fmi3Boolean with_stop, fmi3Float64 stop)
{
    (void)with_tolerance;
    (void)tolerance;
    const fmi3Status status = fmu_enter(c, FMU_INSTANTIATED, FMU_INITIALIZATION);
    return status == fmi3OK ? fmu_done(c, fmu_begin(&((fmu_instance *)c)->state, start, with_stop, stop)) : status;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { return fmu_enter(c, FMU_INITIALIZATION, FMU_RUNNING); }
fmi3Status fmi3EnterEventMode(fmi3Instance c) { return fmu_enter(c, FMU_RUNNING, FMU_RUNNING); }
fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c) { return fmu_enter(c, FMU_RUNNING, FMU_RUNNING); }
fmi3Status fmi3EnterStepMode(fmi3Instance c) { return fmu_enter(c, FMU_RUNNING, FMU_RUNNING); }
fmi3Status fmi3Terminate(fmi3Instance c) { return fmu_enter(c, FMU_RUNNING, FMU_TERMINATED); }
fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) { return fmu_failed(c, "there are no structural parameters"); }
fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) { return fmu_failed(c, "there are no structural parameters"); }

fmi3Status fmi3Reset(fmi3Instance c)
{
    fmu_reset(&((fmu_instance *)c)->state);
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference refs[], size_t n, fmi3Float64 values[], size_t m)
{
    return fmu_done(c, n == m ? fmu_get(&((fmu_instance *)c)->state, refs, n, values) : "all variables are scalars");
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference refs[], size_t n, const fmi3Float64 values[],
    size_t m)
{
    return fmu_done(c, n == m ? fmu_set(&((fmu_instance *)c)->state, refs, n, values) : "all variables are scalars");
}

#define OTHER_TYPE(TYPE) \
    fmi3Status fmi3Get##TYPE(fmi3Instance c, const fmi3ValueReference refs[], size_t n, fmi3##TYPE values[], size_t m) \
    { \
        (void)refs; \
        (void)values; \
        return fmu_none(c, n + m, "all variables are of type Float64"); \
    } \
    fmi3Status fmi3Set##TYPE( \
        fmi3Instance c, const fmi3ValueReference refs[], size_t n, const fmi3##TYPE values[], size_t m) \
    { \
        (void)refs; \
        (void)values; \
        return fmu_none(c, n + m, "all variables are of type Float64"); \
    }

OTHER_TYPE(Float32)
OTHER_TYPE(Int8)
OTHER_TYPE(UInt8)
OTHER_TYPE(Int16)
OTHER_TYPE(UInt16)
OTHER_TYPE(Int32)
OTHER_TYPE(UInt32)
OTHER_TYPE(Int64)
OTHER_TYPE(UInt64)
OTHER_TYPE(Boolean)
OTHER_TYPE(String)

fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference refs[], size_t n, size_t sizes[],
    fmi3Binary values[], size_t m)
{
    (void)refs;
    (void)sizes;
    (void)values;
    return fmu_none(c, n + m, "all variables are of type Float64");
}

fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference refs[], size_t n, const size_t sizes[],
    const fmi3Binary values[], size_t m)
{
    (void)refs;
    (void)sizes;
    (void)values;
    return fmu_none(c, n + m, "all variables are of type Float64");
}

fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference refs[], size_t n, fmi3Clock values[])
{
    (void)refs;
    (void)values;
    return fmu_none(c, n, "there are no clocks");
}

fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference refs[], size_t n, const fmi3Clock values[])
{
    (void)refs;
    (void)values;
    return fmu_none(c, n, "there are no clocks");
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance c, fmi3ValueReference ref, size_t *n)
{
    (void)ref;
    *n = 0;
    return fmu_failed(c, "dependencies stand in the model description");
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance c, fmi3ValueReference dependent, size_t elements[],
    fmi3ValueReference independents[], size_t independent_elements[], fmi3DependencyKind kinds[], size_t n)
{
    (void)dependent;
    (void)elements;
    (void)independents;
    (void)independent_elements;
    (void)kinds;
    (void)n;
    return fmu_failed(c, "dependencies stand in the model description");
}

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    fmu_instance *c = instance;
    if (!*state) {
        *state = malloc(sizeof c->state);
    }
    if (!*state) {
        return fmu_failed(c, "no memory for a state");
    }
    memcpy(*state, &c->state, sizeof c->state);
    return fmi3OK;
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state)
{
    fmu_instance *c = instance;
    if (!state) {
        return fmu_failed(c, "there is no state to set");
    }
    memcpy(&c->state, state, sizeof c->state);
    return fmi3OK;
}

fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state)
{
    (void)c;
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size)
{
    (void)c;
    (void)state;
    *size = sizeof(fmu_state);
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    if (!state || size < sizeof(fmu_state)) {
        return fmu_failed(c, "there is no state, or no room for it");
    }
    memcpy(bytes, state, sizeof(fmu_state));
    return fmi3OK;
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state)
{
    if (size != sizeof(fmu_state)) {
        return fmu_failed(c, "these are not the bytes of a state");
    }
    if (!*state) {
        *state = malloc(sizeof(fmu_state));
    }
    if (!*state) {
        return fmu_failed(c, "no memory for a state");
    }
    memcpy(*state, bytes, sizeof(fmu_state));
    return fmi3OK;
}

static fmi3Status fmu_seeded(fmu_instance *c, const fmi3ValueReference unknowns[], size_t n_unknown,
    const fmi3ValueReference knowns[], size_t n_known, const fmi3Float64 seed[], fmi3Float64 sensitivity[], int sizes,
    int adjoint)
{
    if (!FMU_DERIVATIVES || !sizes) {
        return fmu_failed(c, FMU_DERIVATIVES ? "all variables are scalars" : "this FMU gives no derivatives");
    }
    return fmu_done(c, fmu_derivative(&c->state, unknowns, n_unknown, knowns, n_known, seed, sensitivity, adjoint));
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknowns[], size_t n_unknown,
    const fmi3ValueReference knowns[], size_t n_known, const fmi3Float64 seed[], size_t n_seed,
    fmi3Float64 sensitivity[], size_t n_sensitivity)
{
    const int sizes = n_seed == n_known && n_sensitivity == n_unknown;
    return fmu_seeded(c, unknowns, n_unknown, knowns, n_known, seed, sensitivity, sizes, 0);
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance c, const fmi3ValueReference unknowns[], size_t n_unknown,
    const fmi3ValueReference knowns[], size_t n_known, const fmi3Float64 seed[], size_t n_seed,
    fmi3Float64 sensitivity[], size_t n_sensitivity)
{
    const int sizes = n_seed == n_unknown && n_sensitivity == n_known;
    return fmu_seeded(c, unknowns, n_unknown, knowns, n_known, seed, sensitivity, sizes, 1);
}

/* Clocks: there are none. */
fmi3Status fmi3GetIntervalDecimal(fmi3Instance c, const fmi3ValueReference refs[], size_t n, fmi3Float64 intervals[],
    fmi3IntervalQualifier qualifiers[])
{
    (void)refs;
    (void)intervals;
    (void)qualifiers;
    return fmu_none(c, n, "there are no clocks");
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance c, const fmi3ValueReference refs[], size_t n, fmi3UInt64 counters[],
    fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
{
    (void)refs;
    (void)counters;
    (void)resolutions;
    (void)qualifiers;
    return fmu_none(c, n, "there are no clocks");
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance c, const fmi3ValueReference refs[], size_t n, fmi3Float64 shifts[])
{
    (void)refs;
    (void)shifts;
    return fmu_none(c, n, "there are no clocks");
}

fmi3Status fmi3GetShiftFraction(fmi3Instance c, const fmi3ValueReference refs[], size_t n, fmi3UInt64 counters[],
    fmi3UInt64 resolutions[])
{
    (void)refs;
    (void)counters;
    (void)resolutions;
    return fmu_none(c, n, "there are no clocks");
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance c, const fmi3ValueReference refs[], size_t n,
    const fmi3Float64 intervals[])
{
    (void)refs;
    (void)intervals;
    return fmu_none(c, n, "there are no clocks");
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance c, const fmi3ValueReference refs[], size_t n,
    const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
{
    (void)refs;
    (void)counters;
    (void)resolutions;
    return fmu_none(c, n, "there are no clocks");
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance c, const fmi3ValueReference refs[], size_t n, const fmi3Float64 shifts[])
{
    (void)refs;
    (void)shifts;
    return fmu_none(c, n, "there are no clocks");
}

fmi3Status fmi3SetShiftFraction(fmi3Instance c, const fmi3ValueReference refs[], size_t n, const fmi3UInt64 counters[],
    const fmi3UInt64 resolutions[])
{
    (void)refs;
    (void)counters;
    (void)resolutions;
    return fmu_none(c, n, "there are no clocks");
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance c, fmi3ValueReference clock, fmi3Float64 time)
{
    (void)clock;
    (void)time;
    return fmu_failed(c, "there are no clocks");
}

/* Events: there are none. */
fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c)
{
    (void)c;
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *end, fmi3Boolean *nominals,
    fmi3Boolean *values, fmi3Boolean *next_defined, fmi3Float64 *next)
{
    (void)c;
    *again = fmi3False;
    *end = fmi3False;
    *nominals = fmi3False;
    *values = fmi3False;
    *next_defined = fmi3False;
    *next = 0.0;
    return fmi3OK;
}

/* Model exchange: there are no continuous states. */
fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean no_return, fmi3Boolean *event, fmi3Boolean *end)
{
    (void)c;
    (void)no_return;
    *event = fmi3False;
    *end = fmi3False;
    return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time)
{
    fmu_instance *c = instance;
    return fmu_done(c, c->steps ? "steps move the time" : fmu_set_time(&c->state, time));
}

fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 x[], size_t n)
{
    (void)x;
    return fmu_none(c, n, "there are no continuous states");
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 x[], size_t n)
{
    (void)x;
    return fmu_none(c, n, "there are no continuous states");
}

fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 x[], size_t n)
{
    (void)x;
    return fmu_none(c, n, "there are no continuous states");
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 x[], size_t n)
{
    (void)x;
    return fmu_none(c, n, "there are no continuous states");
}

fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 z[], size_t n)
{
    (void)z;
    return fmu_none(c, n, "there are no event indicators");
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *n)
{
    (void)c;
    *n = 0;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *n)
{
    (void)c;
    *n = 0;
    return fmi3OK;
}

/* Co-simulation. */
fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, const fmi3ValueReference refs[], size_t n,
    const fmi3Int32 orders[], fmi3Float64 values[], size_t m)
{
    (void)refs;
    (void)orders;
    (void)values;
    return fmu_none(c, n + m, "outputs come without derivatives by time");
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 from, fmi3Float64 step, fmi3Boolean no_return,
    fmi3Boolean *event, fmi3Boolean *end, fmi3Boolean *early, fmi3Float64 *last)
{
    fmu_instance *c = instance;
    fmi3Status status;
    (void)no_return;
    *event = fmi3False;
    *end = fmi3False;
    *early = fmi3False;
    if (!c->steps || c->state.mode != FMU_RUNNING) {
        return fmu_failed(c, "a step needs an initialized FMU for co-simulation");
    }
    status = fmu_done(c, fmu_step(&c->state, from, step));
    *last = c->state.time;
    return status;
}
