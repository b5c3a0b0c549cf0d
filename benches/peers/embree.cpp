// The peer of the benchmarks: Intel Embree casts the same rays at the same map, on the same cores.
//
//   c++ -O3 -march=native benches/peers/embree.cpp -o embree-peer -lembree3 -lpthread
//   embree-peer HEIGHTS.r32 COLUMNS ROWS HEIGHT_SCALE THREADS
//
// HEIGHTS.r32 holds COLUMNS × ROWS little-endian floats from 0 to 1, the northern row first; they stand in a box whose
// longer side is 1 and whose height is HEIGHT_SCALE. The map becomes one grid geometry (two triangles per cell), built
// once. After that the program answers its standard input line by line, so that its frames can alternate with
// another program's:
//
//   view EYE RIGHT DOWN DIRECTION WIDTH HEIGHT   four vectors of three numbers: a pixel's ray starts at EYE and goes along
//                                                DIRECTION + x·RIGHT + y·DOWN, x and y from the picture's upper left
//   frame                                        casts all rays; answers with milliseconds, and the rays that hit
//
// The first line it writes is: ready BUILD_MILLISECONDS EMBREE_VERSION. Rays go in coherent packets of 8 × 2; the scene
// is robust, as a terrain without holes needs it.

#include <embree3/rtcore.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iostream>
#include <limits>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace {

constexpr int packet_width = 8, packet_height = 2, packet_size = packet_width * packet_height;
constexpr int tile = 8;

struct Vector {
    float x, y, z;
};

std::istream& operator>>(std::istream& in, Vector& v) { return in >> v.x >> v.y >> v.z; }

struct View {
    Vector eye, right, down, direction;
    int width, height;
};

double milliseconds() {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

[[noreturn]] void fail(const std::string& why) {
    std::cerr << "embree-peer: " << why << '\n';
    std::exit(1);
}

RTCScene build(RTCDevice device, const std::vector<float>& heights, unsigned columns, unsigned rows, float scale) {
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
    RTCGeometry grid = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_GRID);
    auto* points = static_cast<Vector*>(rtcSetNewGeometryBuffer(
        grid, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vector), heights.size()));
    auto* description = static_cast<RTCGrid*>(
        rtcSetNewGeometryBuffer(grid, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, sizeof(RTCGrid), 1));
    if (!points || !description) fail("not enough memory for the map's points");
    const float longer = static_cast<float>(std::max(columns, rows) - 1);
    for (size_t i = 0; i < heights.size(); ++i)
        points[i] = {static_cast<float>(i % columns) / longer, heights[i] * scale, static_cast<float>(i / columns) / longer};
    *description = {0, columns, static_cast<unsigned short>(columns), static_cast<unsigned short>(rows)};
    rtcCommitGeometry(grid);
    rtcAttachGeometry(scene, grid);
    rtcReleaseGeometry(grid);
    rtcCommitScene(scene);
    return scene;
}

int cast_packet(RTCScene scene, const View& view, int left, int top, std::vector<float>& distances) {
    alignas(64) RTCRayHit16 rays;
    alignas(64) int valid[packet_size];
    for (int lane = 0; lane < packet_size; ++lane) {
        const int column = left + lane % packet_width, row = top + lane / packet_width;
        const float x = static_cast<float>(column) + 0.5f, y = static_cast<float>(row) + 0.5f;
        valid[lane] = column < view.width && row < view.height ? -1 : 0;
        rays.ray.org_x[lane] = view.eye.x;
        rays.ray.org_y[lane] = view.eye.y;
        rays.ray.org_z[lane] = view.eye.z;
        rays.ray.dir_x[lane] = view.direction.x + x * view.right.x + y * view.down.x;
        rays.ray.dir_y[lane] = view.direction.y + x * view.right.y + y * view.down.y;
        rays.ray.dir_z[lane] = view.direction.z + x * view.right.z + y * view.down.z;
        rays.ray.tnear[lane] = 0.0f;
        rays.ray.tfar[lane] = std::numeric_limits<float>::infinity();
        rays.ray.time[lane] = 0.0f;
        rays.ray.mask[lane] = ~0u;
        rays.ray.flags[lane] = 0;
        rays.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    }
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect16(valid, scene, &context, &rays);
    int hits = 0;
    for (int lane = 0; lane < packet_size; ++lane) {
        if (!valid[lane]) continue;
        const int column = left + lane % packet_width, row = top + lane / packet_width;
        distances[static_cast<size_t>(row) * view.width + column] = rays.ray.tfar[lane];
        hits += rays.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID;
    }
    return hits;
}

int cast_frame(RTCScene scene, const View& view, int threads, std::vector<float>& distances) {
    const int columns = (view.width + tile - 1) / tile, rows = (view.height + tile - 1) / tile;
    std::atomic<int> next{0}, hits{0};
    const auto work = [&] {
        int found = 0;
        for (int i = next++; i < columns * rows; i = next++) {
            const int left = i % columns * tile, top = i / columns * tile;
            for (int row = top; row < std::min(top + tile, view.height); row += packet_height)
                found += cast_packet(scene, view, left, row, distances);
        }
        hits += found;
    };
    std::vector<std::thread> others;
    for (int i = 1; i < threads; ++i) others.emplace_back(work);
    work();
    for (auto& other : others) other.join();
    return hits;
}

}  // namespace

int main(int count, char** arguments) {
    if (count != 6) fail("usage: embree-peer HEIGHTS.r32 COLUMNS ROWS HEIGHT_SCALE THREADS");
    const unsigned columns = std::stoul(arguments[2]), rows = std::stoul(arguments[3]);
    const float scale = std::stof(arguments[4]);
    const int threads = std::max(std::stoi(arguments[5]), 1);
    if (columns < 2 || rows < 2 || columns > 32767 || rows > 32767) fail("a grid has 2 to 32767 columns and rows");
    std::vector<float> heights(static_cast<size_t>(columns) * rows);
    std::ifstream file(arguments[1], std::ios::binary);
    if (!file.read(reinterpret_cast<char*>(heights.data()), static_cast<std::streamsize>(heights.size() * sizeof(float))))
        fail(std::string("cannot read ") + arguments[1]);

    const double start = milliseconds();
    RTCDevice device = rtcNewDevice(("threads=" + std::to_string(threads)).c_str());
    if (!device) fail("no Embree device");
    RTCScene scene = build(device, heights, columns, rows, scale);
    if (rtcGetDeviceError(device) != RTC_ERROR_NONE) fail("Embree could not build the scene");
    std::cout << "ready " << milliseconds() - start << ' ' << RTC_VERSION_STRING << std::endl;

    View view{};
    std::vector<float> distances;
    for (std::string line; std::getline(std::cin, line);) {
        std::istringstream words(line);
        std::string command;
        words >> command;
        if (command == "view") {
            if (!(words >> view.eye >> view.right >> view.down >> view.direction >> view.width >> view.height) ||
                view.width < 1 || view.height < 1)
                fail("a view is four vectors and a size");
            distances.assign(static_cast<size_t>(view.width) * view.height, 0.0f);
        } else if (command == "frame") {
            const double begin = milliseconds();
            const int hits = cast_frame(scene, view, threads, distances);
            std::cout << milliseconds() - begin << ' ' << hits << std::endl;
        } else {
            fail("unknown command: " + command);
        }
    }
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
}
