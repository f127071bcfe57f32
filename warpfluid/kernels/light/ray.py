"""What a ray through a medium does, as native source: where it reads, what it meets, how its light adds up.

Rays are cut at the planes of voxels that they cross most squarely. On those a field is read with four taps, and
between two of them light is integrated by the trapezoid rule: without extinction that is Joseph's projector (1982).
Where more than the tolerance changes from one plane to the next, the interval is halved, up to 16 times finer, and
the field is read between the planes as well. Extinction is linear and light is given off evenly within an interval,
so that a ray's transmittance and the light that is scattered in uniform surroundings stay exact.
"""

from warpfluid.kernels.light.bricks import BRICK

CAMERA = 16  # numbers: eye, right, up, forward (x, z, y each), pixel, shift right, shift up, perspective
EXTINCTION, EMISSION, ALBEDO = range(3)
MOST_SUNS = 8
UNSEEN = 1 / 64  # of what there may be between two planes at the most
SHARE = 1 / 6  # of the tolerance that one interval may use up
FINEST = 1 / 16  # of the distance between two planes

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
    const size_t stride_d = strides[d], stride_a = strides[a], stride_b = strides[b];
    const int size_d = size[d], size_a = size[a], size_b = size[b];
"""

# Defines `place(q)`: taps and weights at coordinate q of the main axis, on one plane or two; 0 is read beyond the box,
# and the nearest voxel of what `around` reads.
PLACE = """
    struct Axis { size_t low, high; float share, first, second; };
    struct Place { Axis along; size_t at[4]; float weight[4], clamped[4]; };
    const auto axis_at = [](double p, int n, size_t stride) {
        const int i = (int)(p + 4.0) - 4;
        const float share = (float)(p - i);
        if (i >= 0 && i + 1 < n) return Axis{i * stride, (i + 1) * stride, share, 1.0f - share, share};
        const size_t low = wp::clamp(i, 0, n - 1) * stride, high = wp::clamp(i + 1, 0, n - 1) * stride;
        return Axis{low, high, share, i >= 0 && i < n ? 1.0f - share : 0.0f, i >= -1 && i + 1 < n ? share : 0.0f};
    };
    const auto place = [&](double q) {
        const Axis one = axis_at(base_a + q * slope_a, size_a, stride_a);
        const Axis two = axis_at(base_b + q * slope_b, size_b, stride_b);
        const float s = one.share, t = two.share;
        return Place{
            axis_at(q, size_d, stride_d),
            {one.low + two.low, one.low + two.high, one.high + two.low, one.high + two.high},
            {one.first * two.first, one.first * two.second, one.second * two.first, one.second * two.second},
            {(1.0f - s) * (1.0f - t), (1.0f - s) * t, s * (1.0f - t), s * t}};
    };
    const auto on_plane = [](const float* data, int step, size_t plane, const Place& here, const float* weight) {
        const float* from_plane = data + step * plane;
        return weight[0] * from_plane[step * here.at[0]] + weight[1] * from_plane[step * here.at[1]]
            + weight[2] * from_plane[step * here.at[2]] + weight[3] * from_plane[step * here.at[3]];
    };
    const auto read = [&](const float* data, const Place& here) {
        const float first = here.along.first * on_plane(data, 1, here.along.low, here, here.weight);
        if (here.along.share == 0.0f) return first;
        return first + here.along.second * on_plane(data, 1, here.along.high, here, here.weight);
    };
    const auto around = [&](const float* data, int step, const Place& here) {
        const float first = on_plane(data, step, here.along.low, here, here.clamped);
        if (here.along.share == 0.0f) return first;
        return first + here.along.share * (on_plane(data, step, here.along.high, here, here.clamped) - first);
    };
"""

# Defines `meet(q)`: what the medium does at a place: extinction, light given off, light given off or scattered.
MEET = f"""
    struct Sample {{ double q; float density, extinction, emission[3], light[3]; }};
    float sun[3 * {MOST_SUNS}];
    const int suns = scene.shadows.data ? scene.shadows.shape[0] : 0;
    const double g = scene.anisotropy;
    const size_t voxels = (size_t)size[0] * size[1] * size[2];
    for (int k = 0; k < suns; ++k) {{
        const float* to_sun = scene.suns.data + 6 * k;
        const double cosine = (to_sun[0] * toward[0] + to_sun[1] * toward[1] + to_sun[2] * toward[2])
            / wp::sqrt(ax * ax + az * az + ay * ay);
        const double base = 1.0 + g * g - 2.0 * g * cosine;
        const double phase = (1.0 - g * g) / (12.566370614359172 * base * wp::sqrt(base));
        for (int c = 0; c < 3; ++c) sun[3 * k + c] = (float)(to_sun[3 + c] * phase);
    }}
    struct Entry {{ int low, high; float share, factor; }};
    const auto entry = [&](int which, int count, const float* values) {{
        const float at = wp::clamp(values[scene.reads[which]] * scene.per_entry[which], 0.0f, (float)(count - 1));
        const int low = (int)at, times = scene.times[which];
        return Entry{{low, wp::min(low + 1, count - 1), at - low, times < 0 ? 1.0f : wp::max(values[times], 0.0f)}};
    }};
    const auto colour = [&](int which, const wp::array_t<float>& entries, const float* values, float* out) {{
        const Entry e = entry(which, entries.shape[0], values);
        const float *low = entries.data + 3 * e.low, *high = entries.data + 3 * e.high;
        for (int c = 0; c < 3; ++c) out[c] = e.factor * (low[c] + e.share * (high[c] - low[c]));
    }};
    const auto fade_at = [&](double q) {{
        const double at[3] = {{q, base_a + q * slope_a, base_b + q * slope_b}};
        const int sizes[3] = {{size_d, size_a, size_b}};
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
        colour({ALBEDO}, scene.albedo, values, albedo);
        if (scene.ambient.data)
            for (int c = 0; c < 3; ++c) arriving[c] = around((const float*)scene.ambient.data + c, 3, here);
        for (int k = 0; k < suns; ++k) {{
            const float open = around(scene.shadows.data + k * voxels, 1, here);
            for (int c = 0; c < 3; ++c) arriving[c] += open * sun[3 * k + c];
        }}
        for (int c = 0; c < 3; ++c) found.light[c] += found.extinction * albedo[c] * arriving[c];
    }};
    const auto meet = [&](double q) {{
        Sample found = {{q}};
        const Place here = place(q);
        float values[4] = {{read(scene.f0.data, here)}};
        if (scene.field_count > 1) values[1] = read(scene.f1.data, here);
        if (scene.field_count > 2) values[2] = read(scene.f2.data, here);
        if (scene.field_count > 3) values[3] = read(scene.f3.data, here);
        if (scene.density_field >= 0) found.density = values[scene.density_field];
        if (scene.clear && wp::max(wp::max(values[0], values[1]), wp::max(values[2], values[3])) <= 0.0f) return found;
        const float fade = scene.edge_fade > 0.0f ? fade_at(q) : 1.0f;
        if (scene.extinction.data) {{
            const Entry e = entry({EXTINCTION}, scene.extinction.shape[0], values);
            const float low = scene.extinction.data[e.low], high = scene.extinction.data[e.high];
            found.extinction = fade * e.factor * (low + e.share * (high - low));
        }}
        if (scene.emission.data) {{
            colour({EMISSION}, scene.emission, values, found.emission);
            for (int c = 0; c < 3; ++c) found.light[c] = found.emission[c] *= fade;
        }}
        if (scene.albedo.data && found.extinction > 0.0f) scatter(here, values, found);
        return found;
    }};
"""

# Defines `pass(start, end)`: adds an interval's light to `seen` and `glow`, and its opacity to `hidden`.
PASS = """
    float open = 1.0f, hidden = 0.0f, seen[3] = {}, glow[3] = {}, density_sum = 0.0f;
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
        hidden += open * (depth < 0.1f ? depth * mean : 1.0f - kept);
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
    const float slant = (float)wp::max(wp::abs(slope_a), wp::abs(slope_b));
    float unknown = 0.0f;  // how much more than seen on the planes may be met between them
    const auto may_err = [&](const Sample& start, const Sample& end) {
        const float h = length * (float)wp::abs(end.q - start.q);
        float most = wp::abs(end.extinction - start.extinction);
        for (int c = 0; c < 3; ++c) most = wp::max(most, wp::abs(end.light[c] - start.light[c]));
        const float unseen = unknown * h * (float)wp::abs(end.q - start.q) * wp::abs(end.q - start.q);
        return wp::max(open * wp::max(h * most * 0.125f, unseen), unequal(start, end, h));
    };
    const auto does_err = [&](const Sample& start, const Sample& middle, const Sample& end) {
        const float h = length * (float)wp::abs(end.q - start.q);
        float most = wp::abs(start.extinction + end.extinction - 2.0f * middle.extinction);
        for (int c = 0; c < 3; ++c)
            most = wp::max(most, wp::abs(start.light[c] + end.light[c] - 2.0f * middle.light[c]));
        return wp::max(open * h * most * 0.25f, 0.25f * unequal(start, end, h));
    };
"""

# Defines `bound()` and `halve(start, end)`: passes an interval in as many parts as keep the error within the bound.
HALVE = f"""
    const auto bound = [&]() {{
        return {SHARE} * scene.error * wp::max(1.0f, wp::max(seen[0], wp::max(seen[1], seen[2])));
    }};
    const auto halve = [&](Sample start, const Sample& end) {{
        Sample ends[6] = {{end}};
        for (int top = 0; top >= 0; --top) {{
            while (wp::abs(ends[top].q - start.q) > {FINEST} && may_err(start, ends[top]) > bound()) {{
                const Sample middle = meet(0.5 * (start.q + ends[top].q));
                const float error = does_err(start, middle, ends[top]);
                ends[++top] = middle;
                if (error <= bound()) break;
            }}
            pass(start, ends[top]);
            start = ends[top];
        }}
    }};
"""

# Defines `mark(q)` and `half_way()`: where the ray's opacity and light are half of what they come to.
HALF_WAY = """
    enum { BINS = 64 };
    float reached[BINS], per_bin = 1.0f, total = 0.0f;
    int filled = 0;
    double begun = from;
    const auto mark = [&](double q) {
        const float now = hidden + (seen[0] + seen[1] + seen[2]) * (1.0f / 3.0f);
        if (now <= total) {
            if (now == 0.0f) begun = q;
            return;
        }
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

# Defines `dark(q, planes)`: whether there is nothing to meet, and for how many planes on that is known.
DARK = f"""
    const double pace[3] = {{1.0 * way, way * slope_a, way * slope_b}};
    const double wait[3] = {{1.0, 1.0 / pace[1], 1.0 / pace[2]}};
    const int last[3] = {{scene.bricks.shape[d] - 1, scene.bricks.shape[a] - 1, scene.bricks.shape[b] - 1}};
    const int stride[3] = {{scene.bricks.shape[1] * scene.bricks.shape[2], scene.bricks.shape[2], 1}};
    const int hop[3] = {{stride[d], stride[a], stride[b]}};
    const auto dark = [&](double q, int& planes) {{
        const double p[3] = {{q, base_a + q * slope_a, base_b + q * slope_b}};
        const int cell = (int)(way > 0 ? wp::floor(q) : wp::ceil(q) - 1);
        int at = 0;
        float ahead = 1e6f;
        for (int i = 0; i < 3; ++i) {{
            const int brick = wp::clamp((i ? (int)(p[i] + 8.0) - 8 : cell) >> {BRICK.bit_length() - 1}, 0, last[i]);
            at += brick * hop[i];
            if (pace[i] > 0.0 ? brick == last[i] : pace[i] < 0.0 ? brick == 0 : true) continue;
            const double end = {BRICK} * (brick + (pace[i] > 0.0 ? 1 : 0));
            ahead = wp::min(ahead, (float)(i ? (end - p[i]) * wait[i] : wp::abs(end - cell - (way < 0))));
        }}
        planes = wp::max((int)ahead, 1);
        const float most = scene.bricks.data[at];
        unknown = {UNSEEN} * slant * most;
        return most == 0.0f;
    }};
"""
