// See ugly_inputs.h.
#include "tests/app/ugly_inputs.h"

namespace likeness::test {
namespace {

constexpr double kLast_s = (kGoodFrames - 1) / 25.0;

constexpr UglyInput kInputs[] = {
    // Containers and codecs.
    {"a.mov", R"(ff -i "$CLIP" -c copy a.mov)", kGoodFrames, kLast_s},
    {"b.mkv", R"(ff -i "$CLIP" -c copy b.mkv)", kGoodFrames, kLast_s},
    {"c.webm", R"(ff -i "$CLIP" -c:v libvpx -b:v 1M -an c.webm)", kGoodFrames, kLast_s},
    {"d.webm", R"(ff -i "$CLIP" -c:v libvpx-vp9 -cpu-used 8 -b:v 1M -an d.webm)", kGoodFrames, kLast_s},
    {"e.avi", R"(ff -i "$CLIP" -c:v mjpeg -q:v 3 -c:a pcm_s16le e.avi)", kGoodFrames, kLast_s},
    {"f.ts", R"(ff -i "$CLIP" -c copy f.ts)", kGoodFrames, kLast_s},
    {"g.mp4", R"(ff -i "$CLIP" -c copy -movflags frag_keyframe+empty_moov g.mp4)", kGoodFrames, kLast_s},
    {"h.mp4", R"(ff -i "$CLIP" -c copy -movflags faststart h.mp4)", kGoodFrames, kLast_s},
    {"i.flv", R"(ff -i "$CLIP" -c copy i.flv)", kGoodFrames, kLast_s},
    {"j.3gp", R"(ff -i "$CLIP" -c:v mpeg4 -q:v 3 -an j.3gp)", kGoodFrames, kLast_s},
    {"k.mpg", R"(ff -i "$CLIP" -c:v mpeg2video -q:v 3 -an k.mpg)", kGoodFrames, kLast_s},
    {"l.mov", R"(ff -i "$CLIP" -c:v prores_ks -an l.mov)", kGoodFrames, kLast_s},
    {"m.mkv", R"(ff -i "$CLIP" -c:v ffv1 -an m.mkv)", kGoodFrames, kLast_s},
    {"n.mp4", R"(ff -i "$CLIP" -c:v libx265 -preset ultrafast -x265-params log-level=none -an n.mp4)",
     kGoodFrames, kLast_s},
    {"o.mp4",
     R"(ff -i "$CLIP" -c:v libsvtav1 -preset 12 -an o.mp4 2> /dev/null || ff -i "$CLIP" -c copy o.mp4)",
     kGoodFrames, kLast_s},
    {"p.mp4", R"(ff -i "$CLIP" -c:v copy -an -bsf:v h264_mp4toannexb -f h264 p.mp4)", kGoodFrames, -1},
    {"q.nut", R"(ff -i "$CLIP" -c copy q.nut)", kGoodFrames, kLast_s},
    {"intra only.mp4", R"(ff -i "$CLIP" -g 1 -an 'intra only.mp4')", kGoodFrames, kLast_s},
    {"interlaced.mp4", R"(ff -i "$CLIP" -flags +ilme+ildct -an interlaced.mp4)", kGoodFrames, kLast_s},

    // Clocks.
    {"late clock.mkv", R"(ff -i "$CLIP" -c copy -output_ts_offset 4 'late clock.mkv')", kGoodFrames, -1, "",
     true},
    {"late clock.mp4", R"(ff -i "$CLIP" -c copy -output_ts_offset 4 'late clock.mp4')", kGoodFrames, -1},
    {"thinned.mp4",
     R"(ff -i "$CLIP" -vf "select='if(lt(t,1),1,not(mod(n,3)))'" -fps_mode vfr -enc_time_base 1/600 )"
     R"(-video_track_timescale 600 -c:a copy thinned.mp4)",
     30, -1, "", true},
    {"pause.mp4",
     R"(ff -i "$CLIP" -vf "setpts='if(lt(N,20),PTS,PTS+3/TB)'" -fps_mode passthrough -an pause.mp4)",
     kGoodFrames, kLast_s + 3},
    {"jumps back.ts", R"(ff -i "$CLIP" -c copy half.ts && cat half.ts half.ts > 'jumps back.ts')",
     2 * kGoodFrames, -1, "", true},
    {"sound outlasts.mkv",
     R"(ff -i "$CLIP" -f lavfi -i sine=d=5 -map 0:v -map 1:a -c:v copy -c:a aac 'sound outlasts.mkv')",
     kGoodFrames, kLast_s, "", true},
    {"picture late.mkv",
     R"(ff -itsoffset 2 -i "$CLIP" -f lavfi -i sine=d=5 -map 0:v -map 1:a -c:v copy -c:a aac 'picture late.mkv')",
     kGoodFrames, -1},
    {"sound stops.mp4",
     R"(ff -i "$CLIP" -f lavfi -i sine=d=0.3 -map 0:v -map 1:a -c:v copy -c:a aac 'sound stops.mp4')",
     kGoodFrames, kLast_s},
    {"23.976.mp4", R"(ff -r 24000/1001 -i "$CLIP" -map 0:v 23.976.mp4)", kGoodFrames, 39 * 1001 / 24000.0},
    {"240.mp4", R"(ff -r 240 -i "$CLIP" -map 0:v 240.mp4)", 0, -1, "at least 30"},
    {"one a second.mp4", R"(ff -r 1 -i "$CLIP" -map 0:v 'one a second.mp4')", kGoodFrames, 39},
    {"edit list.mp4", R"(ff -ss 0.2 -i "$CLIP" -c copy 'edit list.mp4')", 35, -1},
    {"coarse clock.mp4", R"(ff -i "$CLIP" -c:v copy -an -video_track_timescale 30 'coarse clock.mp4')",
     kGoodFrames, kLast_s},
    {"doubled frames.mp4", R"(ff -i "$CLIP" -vf fps=60 -an 'doubled frames.mp4')", 96, -1},

    // Sizes and how they are held.
    {"odd.mkv", R"(ff -i "$CLIP" -vf scale=157:149 -c:v ffv1 -an odd.mkv)", kGoodFrames, kLast_s},
    {"tall.mp4", R"(ff -i "$CLIP" -vf pad=160:300:0:60 -an tall.mp4)", kGoodFrames, kLast_s},
    {"wide.mp4", R"(ff -i "$CLIP" -vf pad=400:160:120:0 -an wide.mp4)", kGoodFrames, kLast_s},
    {"anamorphic.mp4", R"(ff -i "$CLIP" -vf scale=106:160,setsar=3/2 -an anamorphic.mp4)", kGoodFrames,
     kLast_s},
    {"turned.mp4", R"(ff -i "$CLIP" -vf transpose=1 -an t.mp4 && turn 90 t.mp4 turned.mp4)", kGoodFrames,
     kLast_s, "", true},
    {"turned twice.mp4", R"(ff -i "$CLIP" -vf hflip,vflip -an t.mp4 && turn 180 t.mp4 'turned twice.mp4')",
     kGoodFrames, kLast_s},
    {"another size.webm",
     R"(ff -i "$CLIP" -vf scale=256:256 -c:v libvpx -b:v 1M -an 1.webm && ff -i "$CLIP" -vf )"
     R"(pad=180:320:10:60 -c:v libvpx -b:v 1M -an 2.webm && printf "file 1.webm\nfile 2.webm\n" > l && )"
     R"(ff -f concat -i l -c copy 'another size.webm')",
     2 * kGoodFrames, -1, "", true},
    {"tiny.mp4", R"(ff -i "$CLIP" -vf scale=16:16 -an tiny.mp4)", 0, -1, "face"},
    {"two px.mkv", R"(ff -i "$CLIP" -vf scale=2:2 -c:v ffv1 -an 'two px.mkv')", 0, -1, "face"},

    // Tracks.
    {"sound alone.mp4", R"(ff -i "$CLIP" -map 0:a -c copy 'sound alone.mp4')", 0, -1,
     "holds sound but no video", true},
    {"cover.mp4",
     R"(ff -i "$CLIP" -frames:v 1 c.png && ff -i "$CLIP" -i c.png -map 0 -map 1 -c copy -disposition:v:1 )"
     R"(attached_pic cover.mp4)",
     kGoodFrames, kLast_s},
    {"cover first.mp4",
     R"(ff -i "$CLIP" -frames:v 1 c.png && ff -i c.png -i "$CLIP" -map 0 -map 1 -c copy -disposition:v:0 )"
     R"(attached_pic 'cover first.mp4')",
     kGoodFrames, kLast_s},
    {"two pictures.mp4",
     R"(ff -i "$CLIP" -f lavfi -i testsrc=s=320x320:d=2 -map 1:v -map 0:v -c:v libx264 -disposition:v:0 0 )"
     R"(-disposition:v:1 default 'two pictures.mp4')",
     kGoodFrames, kLast_s},
    {"three sounds.mkv", R"(ff -i "$CLIP" -map 0:v -map 0:a -map 0:a -map 0:a -c copy 'three sounds.mkv')",
     kGoodFrames, kLast_s},
    {"titles.mkv",
     R"(printf '1\n00:00:00,000 --> 00:00:01,000\nHello\n' > t.srt; ff -i "$CLIP" -i t.srt -map 0 -map 1 -c:v )"
     R"(copy -c:a copy -c:s srt titles.mkv)",
     kGoodFrames, kLast_s},
    {"no sound.mp4", R"(ff -i "$CLIP" -an -c copy 'no sound.mp4')", kGoodFrames, kLast_s},

    // Colours.
    {"444.mp4", R"(ff -i "$CLIP" -pix_fmt yuv444p -an 444.mp4)", kGoodFrames, kLast_s},
    {"10 bit.mp4", R"(ff -i "$CLIP" -pix_fmt yuv422p10le -an '10 bit.mp4')", kGoodFrames, kLast_s},
    {"grey.mp4", R"(ff -i "$CLIP" -pix_fmt gray -an grey.mp4)", kGoodFrames, kLast_s},
    {"full range.mp4", R"(ff -i "$CLIP" -vf scale=out_range=pc -color_range pc -an 'full range.mp4')",
     kGoodFrames, kLast_s},
    {"hlg.mp4",
     R"(ff -i "$CLIP" -pix_fmt yuv420p10le -color_primaries bt2020 -color_trc arib-std-b67 -colorspace bt2020nc )"
     R"(-an hlg.mp4)",
     kGoodFrames, kLast_s},
    {"rgb.mov", R"(ff -i "$CLIP" -c:v qtrle -an rgb.mov)", kGoodFrames, kLast_s},
    {"png.mov", R"(ff -i "$CLIP" -c:v png -an png.mov)", kGoodFrames, kLast_s},
    {"cut out.webm",
     R"(ff -i "$CLIP" -vf "format=yuva420p,geq=lum='lum(X,Y)':cb='cb(X,Y)':cr='cr(X,Y)':a='if(lt(Y,20),0,255)'" )"
     R"(-c:v libvpx-vp9 -cpu-used 8 -b:v 1M -auto-alt-ref 0 -an 'cut out.webm')",
     kGoodFrames, kLast_s},
    {"dark.mp4", R"(ff -i "$CLIP" -vf eq=brightness=-.4 -an dark.mp4)", kGoodFrames, kLast_s},

    // Names.
    {"two  blanks .mp4", R"(cp "$CLIP" 'two  blanks .mp4')", kGoodFrames, kLast_s},
    {"line\nbreak.mp4", R"(cp "$CLIP" "$OUT")", kGoodFrames, kLast_s, "", true},
    {"'\"$(x)`;&|.mp4", R"(cp "$CLIP" "$OUT")", kGoodFrames, kLast_s},
    {"100%03d.mp4", R"(cp "$CLIP" "$OUT")", kGoodFrames, kLast_s},
    {"a:b.mp4", R"(cp "$CLIP" "$OUT")", kGoodFrames, kLast_s},
    {"concat:x|y.mp4", R"(cp "$CLIP" "$OUT")", kGoodFrames, kLast_s},
    {"back\\slash.mp4", R"(cp "$CLIP" "$OUT")", kGoodFrames, kLast_s},
    {"m\xfcller.mp4", R"(cp "$CLIP" "$OUT")", kGoodFrames, kLast_s, "", true},
    {"\xe6\x98\xa0\xe5\x83\x8f\xf0\x9f\x98\x80.mp4", R"(cp "$CLIP" "$OUT")", kGoodFrames, kLast_s},
    {"CAPITALS.MP4", R"(cp "$CLIP" "$OUT")", kGoodFrames, kLast_s},
    {"no extension", R"(cp "$CLIP" "$OUT")", kGoodFrames, kLast_s},
    {"film.jpg", R"(cp "$CLIP" "$OUT")", kGoodFrames, kLast_s},
    {"[1-3]*?.mp4", R"(cp "$CLIP" "$OUT")", kGoodFrames, kLast_s},
    {".hidden.mp4", R"(cp "$CLIP" "$OUT")", kGoodFrames, kLast_s},
    {"link.mp4", R"(ln -s "$CLIP" link.mp4)", kGoodFrames, kLast_s},
    {"link nowhere.mp4", R"(ln -s nowhere 'link nowhere.mp4')", 0, -1, "link nowhere.mp4"},
    {"absent.mp4", R"(true)", 0, -1, "absent.mp4"},

    // No film.
    {"empty.mp4", R"(: > empty.mp4)", 0, -1, "empty", true},
    {"one byte.mp4", R"(printf x > 'one byte.mp4')", 0, -1, "not a video"},
    {"zeros.mp4", R"(head -c 100000 /dev/zero > zeros.mp4)", 0, -1, "not a video"},
    {"page.mp4", R"(echo '<html><body>404</body></html>' > page.mp4)", 0, -1, "not a video"},
    {"list.mp4", R"(printf '#EXTM3U\n#EXTINF:1,\n%s\n' "$CLIP" > list.mp4)", 0, -1, "list.mp4"},
    {"joined.mp4", R"(printf "ffconcat version 1.0\nfile '%s'\n" "$CLIP" > joined.mp4)", 0, -1,
     "none of the kinds"},
    {"archive.mp4", R"(tar cf archive.mp4 "$CLIP" 2> /dev/null)", 0, -1, ""},
    {"picture.mp4", R"(ff -i "$CLIP" -frames:v 1 x.png && mv x.png picture.mp4)", 0, -1, "none of the kinds"},
    {"pipe.mp4", R"(mkfifo pipe.mp4)", 0, -1, "pipe", true},

    // Damage.
    {"cut short.mp4", R"(head -c 20000 "$CLIP" > 'cut short.mp4')", 0, -1, "cut short", true},
    {"cut short.mkv", R"(ff -i "$CLIP" -c copy x.mkv && head -c -4000 x.mkv > 'cut short.mkv')", -1, -1,
     "cut short"},
    {"garbled.mkv",
     R"(ff -i "$CLIP" -c copy x.mkv && { head -c 20000 x.mkv; head -c 2000 /dev/urandom; tail -c +22001 x.mkv; } )"
     R"(> garbled.mkv)",
     -1, -1, ""},
    {"behind it.mp4", R"({ cat "$CLIP"; head -c 5000 /dev/urandom; } > 'behind it.mp4')", kGoodFrames,
     kLast_s},

    // What is seen.
    {"bars.mp4", R"(ff -f lavfi -i smptebars=s=160x160:d=2:r=30 bars.mp4)", 0, -1, "face"},
    {"black.mp4", R"(ff -f lavfi -i color=black:s=160x160:d=2:r=30 black.mp4)", 0, -1, "face"},
    {"frozen.mp4", R"(ff -i "$CLIP" -vf "loop=60:1:0,trim=end_frame=60" -an frozen.mp4)", -1, -1, ""},
    {"upside down.mp4", R"(ff -i "$CLIP" -vf vflip -an 'upside down.mp4')", kGoodFrames, kLast_s},
    {"short.mp4", R"(ff -i "$CLIP" -frames:v 20 -an short.mp4)", 0, -1, "at least 30", true},
    {"one frame.mp4", R"(ff -i "$CLIP" -frames:v 1 -an 'one frame.mp4')", 0, -1, "at least 30"},
};

}  // namespace

std::span<const UglyInput> ugly_inputs() { return kInputs; }

}  // namespace likeness::test
