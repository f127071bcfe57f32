"""What a ray through a medium does, as native source: where it reads, what it meets, how its light adds up.

Rays are cut at the planes of voxels that they cross most squarely. On those a field is read with four taps, and
between two of them light is integrated by the trapezoid rule: without extinction that is Joseph's projector (1982).
Where more than the tolerance changes from one plane to the next, the interval is halved, up to 16 times finer, and
the field is read between the planes as well. Extinction is linear and light is given off evenly within an interval,
so that a ray's transmittance and the light that is scattered in uniform surroundings stay exact.
"""

from warpfluid.kernels.bricks import BRICK

CAMERA = 16  # numbers: eye, right, up, forward (x, z, y each), pixel, shift right, shift up, perspective
EXTINCTION, EMISSION, ALBEDO = range(3)
MOST_SUNS = 8

# The ray: `origin`, `toward` (depth 1 along forward), `main` axis and how the others run with it, `from` and `to`.
GEOMETRY = """
    const double* cam = scene.camera.data;
    const int height = color.shape[0], width = color.shape[1];
    const int size[3] = {scene.f0.shape[0], scene.f0.shape[1], scene.f0.shape[2]};
    const double u = (column - 0.5 * (width - 1) + cam[13]) * cam[12];
    const double v = (0.5 * (height - 1) - row + cam[14]) * cam[12];
    double origin[3], toward[3], near = 0.0, far = scene.limits.data ? scene.limits.data[row * width + column] : 1e30;
    const double nearest = near, farthest = far;
    for (int i = 0; i < 3; ++i) {
        const double across = u * cam[3 + i] + v * cam[6 + i];
        origin[i] = cam[i] + (cam[15] ? 0.0 : across);
        toward[i] = cam[9 + i] + (cam[15] ? across : 0.0);
        if (toward[i]) {
            const double one = (-1 - origin[i]) / toward[i], other = (size[i] - origin[i]) / toward[i];
            near = wp::max(near, wp::min(one, other));
            far = wp::min(far, wp::max(one, other));
        } else if (origin[i] <= -1 || origin[i] >= size[i])
            far = -1;
    }
    const double ax = wp::abs(toward[0]), az = wp::abs(toward[1]), ay = wp::abs(toward[2]);
    const int d = ay > wp::max(ax, az) ? 2 : az >= ax ? 1 : 0, a = d ? 0 : 1, b = d == 2 ? 1 : 2;
    const double slope_a = toward[a] / toward[d], slope_b = toward[b] / toward[d];
    const double base_a = origin[a] - origin[d] * slope_a, base_b = origin[b] - origin[d] * slope_b;
    const float length = (float)(wp::sqrt(ax * ax + az * az + ay * ay) / wp::abs(toward[d]));
    const int way = toward[d] > 0 ? 1 : -1;
    double from = origin[d] + near * toward[d], to = origin[d] + far * toward[d];
    if (near > nearest) from = way > 0 ? wp::floor(from) : wp::ceil(from);
    if (far < farthest) to = way > 0 ? wp::ceil(to) : wp::floor(to);
    const size_t strides[3] = {(size_t)size[1] * size[2], (size_t)size[2], 1};
"""

# Defines `place(q)`: the taps and weights at coordinate q of the main axis; 0 is read beyond the box.
PLACE = """
    struct Place { int taps; size_t at[8]; float weight[8], clamped[8]; };
    struct Axis { int low, high; float share, first, second; };
    const auto axis_at = [](double p, int n) {
        const int i = (int)(p + 4.0) - 4;
        const float share = (float)(p - i);
        if (i >= 0 && i + 1 < n) return Axis{i, i + 1, share, 1.0f - share, share};
        const int low = wp::clamp(i, 0, n - 1), high = wp::clamp(i + 1, 0, n - 1);
        return Axis{low, high, share, i >= 0 && i < n ? 1.0f - share : 0.0f, i >= -1 && i + 1 < n ? share : 0.0f};
    };
    const auto place = [&](double q) {
        Place found;
        const Axis along = axis_at(q, size[d]), one = axis_at(base_a + q * slope_a, size[a]);
        const Axis two = axis_at(base_b + q * slope_b, size[b]);
        found.taps = along.share > 0.0f ? 8 : 4;
        for (int i = 0; i < found.taps; ++i) {
            found.at[i] = (i & 4 ? along.high : along.low) * strides[d] + (i & 2 ? one.high : one.low) * strides[a]
                + (i & 1 ? two.high : two.low) * strides[b];
            found.weight[i] = (i & 4 ? along.second : along.first) * (i & 2 ? one.second : one.first)
                * (i & 1 ? two.second : two.first);
            found.clamped[i] = (i & 4 ? along.share : 1.0f - along.share)
                * (i & 2 ? one.share : 1.0f - one.share) * (i & 1 ? two.share : 1.0f - two.share);
        }
        return found;
    };
    const auto read = [](const float* data, const Place& here) {
        float sum = 0.0f;
        for (int i = 0; i < 4; ++i) sum += here.weight[i] * data[here.at[i]];
        for (int i = 4; i < here.taps; ++i) sum += here.weight[i] * data[here.at[i]];
        return sum;
    };
"""

# Defines `meet(q)`: what the medium does at a place: extinction, light given off, light given off or scattered.
MEET = f"""
    struct Sample {{ double q; float density, extinction, emission[3], light[3]; }};
    const float* fields[4] = {{scene.f0.data, scene.f1.data, scene.f2.data, scene.f3.data}};
    float sun[3 * {MOST_SUNS}];
    const int suns = scene.shadows.data ? scene.shadows.shape[0] : 0;
    const double g = scene.anisotropy;
    for (int k = 0; k < suns; ++k) {{
        const float* to_sun = scene.suns.data + 6 * k;
        const double cosine = (to_sun[0] * toward[0] + to_sun[1] * toward[1] + to_sun[2] * toward[2])
            / wp::sqrt(ax * ax + az * az + ay * ay);
        const double base = 1.0 + g * g - 2.0 * g * cosine;
        const double phase = (1.0 - g * g) / (12.566370614359172 * base * wp::sqrt(base));
        for (int c = 0; c < 3; ++c) sun[3 * k + c] = (float)(to_sun[3 + c] * phase);
    }}
    const auto curve = [&](int which, const wp::array_t<float>& entries, const float* values, float* out) {{
        const int last = entries.shape[0] - 1, channels = entries.shape[1], times = scene.times[which];
        const float at = wp::clamp(values[scene.reads[which]] * scene.per_entry[which], 0.0f, (float)last);
        const int low = wp::min((int)at, wp::max(last - 1, 0)), high = wp::min(low + 1, last);
        const float share = at - low, factor = times < 0 ? 1.0f : wp::max(values[times], 0.0f);
        for (int c = 0; c < channels; ++c) {{
            const float first = entries.data[low * channels + c], second = entries.data[high * channels + c];
            out[c] = factor * (first + share * (second - first));
        }}
        if (channels == 1) out[2] = out[1] = out[0];
    }};
    const auto fade_at = [&](double q) {{
        const double at[3] = {{q, base_a + q * slope_a, base_b + q * slope_b}};
        const int sizes[3] = {{size[d], size[a], size[b]}};
        float product = 1.0f;
        for (int i = 0; i < 3; ++i) {{
            const double inside = wp::min(at[i] + 0.5, sizes[i] - 0.5 - at[i]);
            const float part = (float)wp::clamp(inside / scene.edge_fade, 0.0, 1.0);
            product *= part * part * (3.0f - 2.0f * part);
        }}
        return product;
    }};
    const auto scatter = [&](const Place& here, const float* values, Sample& found) {{
        float albedo[3], arriving[3] = {{}};
        curve({ALBEDO}, scene.albedo, values, albedo);
        for (int i = 0; i < here.taps; ++i) {{
            for (int c = 0; c < 3 && scene.ambient.data; ++c)
                arriving[c] += here.clamped[i] * scene.ambient.data[here.at[i]][c];
            for (int k = 0; k < suns; ++k) {{
                const float open = here.clamped[i] * scene.shadows.data[k * strides[0] * size[0] + here.at[i]];
                for (int c = 0; c < 3; ++c) arriving[c] += open * sun[3 * k + c];
            }}
        }}
        for (int c = 0; c < 3; ++c) found.light[c] += found.extinction * albedo[c] * arriving[c];
    }};
    const auto meet = [&](double q) {{
        Sample found = {{q}};
        const Place here = place(q);
        float values[4], out[3];
        for (int i = 0; i < scene.field_count; ++i) values[i] = read(fields[i], here);
        if (scene.density_field >= 0) found.density = values[scene.density_field];
        const float fade = scene.edge_fade > 0.0f ? fade_at(q) : 1.0f;
        if (scene.extinction.data) {{
            curve({EXTINCTION}, scene.extinction, values, out);
            found.extinction = fade * out[0];
        }}
        if (scene.emission.data) {{
            curve({EMISSION}, scene.emission, values, out);
            for (int c = 0; c < 3; ++c) found.light[c] = found.emission[c] = fade * out[c];
        }}
        if (scene.albedo.data && found.extinction > 0.0f) scatter(here, values, found);
        return found;
    }};
"""

# Defines `pass(start, end)`: adds an interval's light to `seen` and `glow`, and takes its share from `open`.
PASS = """
    float open = 1.0f, seen[3] = {}, glow[3] = {}, density_sum = 0.0f;
    const auto pass = [&](const Sample& start, const Sample& end) {
        const float h = length * (float)wp::abs(end.q - start.q);
        const float depth = 0.5f * h * (start.extinction + end.extinction);
        const float kept = depth < 0.1f ? 0.0f : wp::exp(-depth);
        const float mean = depth < 0.1f
            ? 1.0f - depth * (0.5f - depth * (1.0f / 6.0f - depth * (1.0f / 24.0f - depth * (1.0f / 120.0f))))
            : (1.0f - kept) / depth;  // of the transmittance within the interval
        const float factor = 0.5f * h * open * mean;
        for (int c = 0; c < 3; ++c) {
            seen[c] += factor * (start.light[c] + end.light[c]);
            glow[c] += factor * (start.emission[c] + end.emission[c]);
        }
        open *= depth < 0.1f ? 1.0f - depth * mean : kept;
    };
"""

# Defines `may_err` and `does_err`: what an interval may be wrong by, guessed from its ends, and known with its middle.
ERRORS = """
    const auto unequal = [&](const Sample& start, const Sample& end, float h) {  // light and extinction rise apart
        float most = 0.0f;
        for (int c = 0; c < 3; ++c)
            most = wp::max(most, wp::abs(start.light[c] * end.extinction - end.light[c] * start.extinction));
        return open * h * h * most / 12.0f;
    };
    const auto may_err = [&](const Sample& start, const Sample& end) {
        const float h = length * (float)wp::abs(end.q - start.q);
        float most = wp::abs(end.extinction - start.extinction);
        for (int c = 0; c < 3; ++c) most = wp::max(most, wp::abs(end.light[c] - start.light[c]));
        return wp::max(open * h * most * 0.125f, unequal(start, end, h));
    };
    const auto does_err = [&](const Sample& start, const Sample& middle, const Sample& end) {
        const float h = length * (float)wp::abs(end.q - start.q);
        float most = wp::abs(start.extinction + end.extinction - 2.0f * middle.extinction);
        for (int c = 0; c < 3; ++c)
            most = wp::max(most, wp::abs(start.light[c] + end.light[c] - 2.0f * middle.light[c]));
        return wp::max(open * h * most * 0.25f, 0.25f * unequal(start, end, h));
    };
"""

# Defines `mark(q)` and `half_way()`: where the ray's opacity and light are half of what they come to.
HALF_WAY = """
    enum { BINS = 64 };
    float reached[BINS], per_bin = 1.0f, total = 0.0f;
    int filled = 0;
    double begun = from;
    const auto mark = [&](double q) {
        const float now = 1.0f - open + (seen[0] + seen[1] + seen[2]) * (1.0f / 3.0f);
        if (now <= 0.0f) { begun = q; return; }
        int bin = (int)wp::ceil((float)wp::abs(q - begun) * per_bin) - 1;
        for (; bin >= BINS; bin >>= 1, filled = (filled + 1) >> 1, per_bin *= 0.5f) {
            for (int i = filled; i < BINS; ++i) reached[i] = total;
            for (int i = 0; i < BINS / 2; ++i) reached[i] = reached[2 * i + 1];
        }
        for (; filled < bin; ++filled) reached[filled] = total;
        total = now;
        reached[wp::max(bin, 0)] = now;
        filled = wp::max(filled, bin + 1);
    };
    const auto half_way = [&]() {
        int bin = 0;
        while (bin + 1 < filled && reached[bin] < 0.5f * total) ++bin;
        const float low = bin ? reached[bin - 1] : 0.0f;
        const float share = (0.5f * total - low) / wp::max(reached[bin] - low, 1e-30f);
        return (begun + way * (bin + share) / per_bin - origin[d]) / toward[d];
    };
"""

# Defines `dark(q)`: how many planes ahead there is nothing to meet; 0 where there may be something.
DARK = f"""
    const auto dark = [&](double q) {{
        const double p[3] = {{q, base_a + q * slope_a, base_b + q * slope_b}}, run[3] = {{0.0, slope_a, slope_b}};
        const int axes[3] = {{d, a, b}}, cell = (int)(way > 0 ? wp::floor(q) : wp::ceil(q) - 1);
        int at[3];
        float ahead = 1e6f;
        for (int i = 0; i < 3; ++i) {{
            const int last = scene.bricks.shape[axes[i]] - 1;
            const int brick = wp::clamp((i ? (int)(p[i] + 8.0) - 8 : cell) >> {BRICK.bit_length() - 1}, 0, last);
            at[axes[i]] = brick;
            const double pace = way * run[i];
            if (i == 0) {{
                if (way > 0 ? brick < last : brick > 0)
                    ahead = (float)(way > 0 ? {BRICK} * (brick + 1) - cell : cell - {BRICK} * brick + 1);
            }} else if (pace > 0.0 && brick < last)
                ahead = wp::min(ahead, (float)(({BRICK} * (brick + 1) - p[i]) / pace));
            else if (pace < 0.0 && brick > 0)
                ahead = wp::min(ahead, (float)(({BRICK} * brick - p[i]) / pace));
        }}
        if (scene.bricks.data[(at[0] * scene.bricks.shape[1] + at[1]) * scene.bricks.shape[2] + at[2]]) return 0;
        return wp::max((int)ahead, 1);
    }};
"""
