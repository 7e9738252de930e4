// `wrinkle_weights`: how much the skin of each region is pushed together, as weights for wrinkle maps.
//
// For each pair of a region's markers with the distance d now and d0 at rest, the compression is max(0, 1 - d / d0); the
// region's weight is gain times the mean over its pairs, at most 1. Compression follows from distances alone, so moves of the
// whole head do not show.
#include "component.h"

static const port_schema INPUTS[] = {
    {TEXT("markers"), TEXT("Markers"), TEXT("markers on the skin"), 0, 0, 0},
    {TEXT("rest"), TEXT("Markers"), TEXT("the same markers at rest; the first frame counts"), 0, 0, 1},
};
static const port_schema OUTPUTS[] = {
    {TEXT("weights"), TEXT("Curves"), TEXT("one channel a region: 0 at rest or stretched, 1 fully wrinkled"), 0, 0, 0},
};
static const parameter_schema PARAMETERS[] = {
    {TEXT("regions"), TEXT("Regions as `name=prefix,prefix;name=prefix`: markers whose names begin so belong to the region. "
                           "Empty for one region `face` of all markers."),
     {NAME, {.name = TEXT("")}}, {0, 0}, {0, 0}, {0, 0}},
    {TEXT("gain"), TEXT("Weight at a mean compression of 1; skin seldom goes beyond 0.3."),
     {REAL, {.real = 4.0}}, {1, 0.0}, {1, 100.0}, {0, 0}},
};
static const node_schema NODES[] = {
    {TEXT("wrinkle_weights"), TEXT("Measures how far the skin of each region is pushed together, as weights for wrinkle maps."),
     1, {PER_FRAME, {.halo = 0}}, LIST(INPUTS), LIST(OUTPUTS), LIST(PARAMETERS)},
};
static const list ALL = LIST(NODES);

EXPORT("grimace:node/nodes@0.1.0#describe") const list *describe(void) { return &ALL; }

static result answer;

static result *wrong(enum fault_kind kind, string name, string problem) {
    answer.failed = 1;
    answer.fault = (fault){kind, name, problem};
    return &answer;
}

static int begins(string name, const char *prefix, uint32_t length) {
    if (length == 0 || length > name.length) return 0;
    for (uint32_t at = 0; at < length; at++) if (name.text[at] != prefix[at]) return 0;
    return 1;
}

static float distance(const float *a, const float *b) {
    float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return __builtin_sqrtf(x * x + y * y + z * z);
}

typedef struct { string name; uint32_t first, count; } region;

// Where `name` stands among the markers at rest; -1 where it does not.
static int32_t place(const markers *rest, string name) {
    const string *names = rest->names.data;
    for (uint32_t at = 0; at < rest->names.length; at++)
        if (names[at].length == name.length && begins(names[at], name.text, name.length)) return (int32_t)at;
    return -1;
}

EXPORT("grimace:node/nodes@0.1.0#evaluate")
result *evaluate(const char *node, uint32_t node_length, const parameter *parameters, uint32_t parameter_count,
                 const standing *inputs, uint32_t input_count) {
    (void)node, (void)node_length;
    const markers *moving = &input(inputs, input_count, "markers")->markers, *rest = &input(inputs, input_count, "rest")->markers;
    string text = given(parameters, parameter_count, "regions").name;
    double gain = given(parameters, parameter_count, "gain").real;
    const string *names = moving->names.data;
    uint32_t count = moving->names.length;
    if (rest->time.count == 0) return wrong(WRONG_INPUT, (string)TEXT("rest"), (string)TEXT("it has no frame; connect markers at rest"));

    // Members of all regions, region after region.
    uint32_t most = 1;
    for (uint32_t at = 0; at < text.length; at++) most += text.text[at] == ';';
    region *regions = take(most * sizeof(region), 4);
    uint32_t *members = take((size_t)most * count * 4 + 4, 4), region_count = 0, taken = 0;
    if (text.length == 0) {
        regions[region_count++] = (region){TEXT("face"), 0, count};
        for (; taken < count; taken++) members[taken] = taken;
    }
    for (uint32_t at = 0; at < text.length;) {
        uint32_t name_start = at;
        while (at < text.length && text.text[at] != '=') at++;
        if (at == text.length || at == name_start)
            return wrong(WRONG_PARAMETER, (string)TEXT("regions"), (string)TEXT("write it as `brow=browL,browR;jaw=chin`"));
        region *one = &regions[region_count++];
        *one = (region){{text.text + name_start, at - name_start}, taken, 0};
        uint32_t list_start = ++at;
        while (at < text.length && text.text[at] != ';') at++;
        for (uint32_t marker = 0; marker < count; marker++) {
            uint32_t prefix = list_start;
            for (uint32_t end = list_start; end <= at; end++) {
                if (end < at && text.text[end] != ',') continue;
                if (begins(names[marker], text.text + prefix, end - prefix)) { members[taken++] = marker; one->count++; break; }
                prefix = end + 1;
            }
        }
        if (one->count < 2) return wrong(WRONG_PARAMETER, (string)TEXT("regions"), (string)TEXT("a region has fewer than two markers"));
        at++;
    }

    int32_t *places = take((size_t)count * 4 + 4, 4);
    for (uint32_t marker = 0; marker < count; marker++) {
        places[marker] = place(rest, names[marker]);
        if (places[marker] < 0) return wrong(WRONG_INPUT, (string)TEXT("rest"), (string)TEXT("it lacks a marker that `markers` has"));
    }
    const float *points = moving->positions_m.data, *still = rest->positions_m.data;
    uint32_t frame_count = moving->time.count;
    float *weights = take((size_t)frame_count * region_count * 4 + 4, 4);
    for (uint32_t t = 0; t < frame_count; t++) {
        if ((t & 63) == 0 && host_progress((double)t / frame_count, 0, 0)) return wrong(CANCELLED, (string){0}, (string){0});
        const float *now = points + (size_t)t * count * 3;
        for (uint32_t r = 0; r < region_count; r++) {
            const uint32_t *own = members + regions[r].first;
            float sum = 0;
            uint32_t pairs = 0;
            for (uint32_t i = 0; i < regions[r].count; i++)
                for (uint32_t j = i + 1; j < regions[r].count; j++) {
                    float d0 = distance(still + 3 * places[own[i]], still + 3 * places[own[j]]);
                    float d = distance(now + 3 * own[i], now + 3 * own[j]);
                    // A missing marker is NaN, and so are its distances: such a pair says nothing.
                    if (!(d0 > 0) || d != d) continue;
                    sum += d < d0 ? 1 - d / d0 : 0;
                    pairs++;
                }
            float weight = pairs > 0 ? (float)gain * sum / pairs : __builtin_nanf("");
            weights[(size_t)t * region_count + r] = weight > 1 ? 1 : weight;
        }
    }

    string *channels = take(region_count * sizeof(string), 4);
    for (uint32_t r = 0; r < region_count; r++) channels[r] = regions[r].name;
    item *given_item = take(sizeof(item), 8);
    *given_item = (item){.value = {.kind = CURVES}};
    given_item->value.curves = (curves){moving->time, {channels, region_count}, {weights, frame_count * region_count}};
    standing *output = take(sizeof(standing), 4);
    *output = (standing){TEXT("weights"), {given_item, 1}};
    answer.failed = 0;
    answer.outputs = (list){output, 1};
    return &answer;
}
