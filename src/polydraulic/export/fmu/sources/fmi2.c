/* FMI 2.0, model exchange and co-simulation. To link it statically, define FMI2_FUNCTION_PREFIX as the model identifier
   and an underscore. */
#include "fmi2Functions.h"

#include "fmu.h"

typedef struct {
    fmu_state state;
    fmi2CallbackFunctions call;
    fmi2Type type;
    char name[64];
} fmu_instance;

/* Errors are told even if the importer has not asked for logs: nothing fails without a word. */
static fmi2Status fmu_failed(const fmu_instance *c, const char *message)
{
    if (c->call.logger) {
        c->call.logger(c->call.componentEnvironment, c->name, fmi2Error, "logStatusError", message);
    }
    return fmi2Error;
}

static fmi2Status fmu_done(const fmu_instance *c, const char *message)
{
    return message ? fmu_failed(c, message) : fmi2OK;
}

static fmi2Status fmu_other_type(const fmu_instance *c, size_t n)
{
    return n == 0 ? fmi2OK : fmu_failed(c, "all variables are of type Real");
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[])
{
    (void)c;
    (void)on; /* there is nothing to log but errors, which are always told */
    (void)n;
    (void)categories;
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
    const fmi2CallbackFunctions *call, fmi2Boolean visible, fmi2Boolean logging)
{
    fmu_instance *c;
    (void)resources;
    (void)visible;
    (void)logging;
    if (!call || !guid || strcmp(guid, FMU_TOKEN) != 0 || (type == fmi2ModelExchange && !FMU_MODEL_EXCHANGE)) {
        if (call && call->logger) {
            call->logger(call->componentEnvironment, name, fmi2Error, "logStatusError", "wrong GUID or type of FMU");
        }
        return NULL;
    }
    c = call->allocateMemory ? call->allocateMemory(1, sizeof *c) : calloc(1, sizeof *c);
    if (c) {
        c->call = *call;
        c->type = type;
        strncpy(c->name, name ? name : "", sizeof c->name - 1);
        c->name[sizeof c->name - 1] = '\0';
        fmu_reset(&c->state);
    }
    return c;
}

void fmi2FreeInstance(fmi2Component component)
{
    fmu_instance *c = component;
    if (!c) {
        return;
    }
    if (c->call.allocateMemory && c->call.freeMemory) {
        c->call.freeMemory(c);
    } else if (!c->call.allocateMemory) {
        free(c);
    }
}

fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean with_tolerance, fmi2Real tolerance, fmi2Real start,
    fmi2Boolean with_stop, fmi2Real stop)
{
    fmu_instance *c = component;
    (void)with_tolerance;
    (void)tolerance;
    if (c->state.mode != FMU_INSTANTIATED) {
        return fmu_failed(c, "this function may not be called now");
    }
    return fmu_done(c, fmu_begin(&c->state, start, with_stop == fmi2True, stop));
}

static fmi2Status fmu_enter(fmi2Component component, int from, int to)
{
    fmu_instance *c = component;
    if (c->state.mode != from) {
        return fmu_failed(c, "this function may not be called now");
    }
    c->state.mode = to;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return fmu_enter(c, FMU_INSTANTIATED, FMU_INITIALIZATION); }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return fmu_enter(c, FMU_INITIALIZATION, FMU_RUNNING); }
fmi2Status fmi2Terminate(fmi2Component c) { return fmu_enter(c, FMU_RUNNING, FMU_TERMINATED); }

fmi2Status fmi2Reset(fmi2Component c)
{
    fmu_reset(&((fmu_instance *)c)->state);
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference refs[], size_t n, fmi2Real values[])
{
    return fmu_done(c, fmu_get(&((fmu_instance *)c)->state, refs, n, values));
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference refs[], size_t n, const fmi2Real values[])
{
    return fmu_done(c, fmu_set(&((fmu_instance *)c)->state, refs, n, values));
}

#define OTHER_TYPE(TYPE) \
    fmi2Status fmi2Get##TYPE(fmi2Component c, const fmi2ValueReference refs[], size_t n, fmi2##TYPE values[]) \
    { \
        (void)refs; \
        (void)values; \
        return fmu_other_type(c, n); \
    } \
    fmi2Status fmi2Set##TYPE(fmi2Component c, const fmi2ValueReference refs[], size_t n, const fmi2##TYPE values[]) \
    { \
        (void)refs; \
        (void)values; \
        return fmu_other_type(c, n); \
    }

OTHER_TYPE(Integer)
OTHER_TYPE(Boolean)
OTHER_TYPE(String)

static void *fmu_allocate(const fmu_instance *c, size_t size)
{
    return c->call.allocateMemory ? c->call.allocateMemory(1, size) : malloc(size);
}

fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    fmu_instance *c = component;
    if (!*state) {
        *state = fmu_allocate(c, sizeof c->state);
    }
    if (!*state) {
        return fmu_failed(c, "no memory for a state");
    }
    memcpy(*state, &c->state, sizeof c->state);
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate state)
{
    fmu_instance *c = component;
    if (!state) {
        return fmu_failed(c, "there is no state to set");
    }
    memcpy(&c->state, state, sizeof c->state);
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    const fmu_instance *c = component;
    if (state && *state) {
        if (!c->call.allocateMemory) {
            free(*state);
        } else if (c->call.freeMemory) {
            c->call.freeMemory(*state);
        }
        *state = NULL;
    }
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    (void)c;
    (void)state;
    *size = sizeof(fmu_state);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    if (!state || size < sizeof(fmu_state)) {
        return fmu_failed(c, "there is no state, or no room for it");
    }
    memcpy(bytes, state, sizeof(fmu_state));
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    if (size != sizeof(fmu_state)) {
        return fmu_failed(c, "these are not the bytes of a state");
    }
    if (!*state) {
        *state = fmu_allocate(c, sizeof(fmu_state));
    }
    if (!*state) {
        return fmu_failed(c, "no memory for a state");
    }
    memcpy(*state, bytes, sizeof(fmu_state));
    return fmi2OK;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component component, const fmi2ValueReference unknowns[], size_t n_unknown,
    const fmi2ValueReference knowns[], size_t n_known, const fmi2Real seed[], fmi2Real sensitivity[])
{
    fmu_instance *c = component;
    return fmu_done(c, FMU_DERIVATIVES ? fmu_derivative(&c->state, unknowns, n_unknown, knowns, n_known, seed, sensitivity, 0)
                                   : "this FMU gives no derivatives");
}

/* Model exchange: there are no continuous states and no events. */
fmi2Status fmi2EnterEventMode(fmi2Component c) { return fmu_enter(c, FMU_RUNNING, FMU_RUNNING); }
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) { return fmu_enter(c, FMU_RUNNING, FMU_RUNNING); }

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info)
{
    (void)c;
    info->newDiscreteStatesNeeded = fmi2False;
    info->terminateSimulation = fmi2False;
    info->nominalsOfContinuousStatesChanged = fmi2False;
    info->valuesOfContinuousStatesChanged = fmi2False;
    info->nextEventTimeDefined = fmi2False;
    info->nextEventTime = 0.0;
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no_return, fmi2Boolean *event, fmi2Boolean *end)
{
    (void)c;
    (void)no_return;
    *event = fmi2False;
    *end = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component component, fmi2Real time)
{
    fmu_instance *c = component;
    return fmu_done(c, c->type == fmi2ModelExchange ? fmu_set_time(&c->state, time) : "steps move the time");
}

static fmi2Status fmu_none(const fmu_instance *c, size_t n, const char *message)
{
    return n == 0 ? fmi2OK : fmu_failed(c, message);
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n)
{
    (void)x;
    return fmu_none(c, n, "there are no continuous states");
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real x[], size_t n)
{
    (void)x;
    return fmu_none(c, n, "there are no continuous states");
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n)
{
    (void)x;
    return fmu_none(c, n, "there are no continuous states");
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t n)
{
    (void)x;
    return fmu_none(c, n, "there are no continuous states");
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real z[], size_t n)
{
    (void)z;
    return fmu_none(c, n, "there are no event indicators");
}

/* Co-simulation. */
fmi2Status fmi2DoStep(fmi2Component component, fmi2Real from, fmi2Real step, fmi2Boolean no_return)
{
    fmu_instance *c = component;
    (void)no_return;
    if (c->type != fmi2CoSimulation || c->state.mode != FMU_RUNNING) {
        return fmu_failed(c, "a step needs an initialized FMU for co-simulation");
    }
    return fmu_done(c, fmu_step(&c->state, from, step));
}

fmi2Status fmi2CancelStep(fmi2Component c) { return fmu_failed(c, "steps are never pending"); }

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference refs[], size_t n,
    const fmi2Integer order[], const fmi2Real values[])
{
    (void)refs;
    (void)order;
    (void)values;
    return fmu_none(c, n, "inputs are held during a step");
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference refs[], size_t n,
    const fmi2Integer order[], fmi2Real values[])
{
    (void)refs;
    (void)order;
    (void)values;
    return fmu_none(c, n, "outputs come without derivatives by time");
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    if (kind != fmi2LastSuccessfulTime) {
        return fmi2Discard;
    }
    *value = ((fmu_instance *)c)->state.time;
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    (void)c;
    if (kind != fmi2Terminated) {
        return fmi2Discard;
    }
    *value = fmi2False;
    return fmi2OK;
}

#define NO_STATUS(NAME, TYPE) \
    fmi2Status fmi2Get##NAME(fmi2Component c, const fmi2StatusKind kind, TYPE *value) \
    { \
        (void)c; \
        (void)kind; \
        (void)value; \
        return fmi2Discard; \
    }

NO_STATUS(Status, fmi2Status)
NO_STATUS(IntegerStatus, fmi2Integer)
NO_STATUS(StringStatus, fmi2String)
