### What the window says. One message a line or block; variables are named in braces.

## The panel

fold = fold (P)
unfold = Panel (P)
others-join = Others join with
address = address  { $address }
code = code
copy-command = Copy the command
copy-link = Copy the link
qr-code = Code for a camera
wheel-rpm = wheel, rpm
wheel-centre = centre
wheel-open = open
wheel-pull = pull
wheel-trim = trim
sphere = sphere
tool-rib = rib
tool-blade = blade
tool-knuckle = knuckle
tool-loop = loop
tool-numbered = no. { $number }
radius = radius
angle-turn = turn
angle-lean = lean
angle-roll = roll
side-outside = outside
side-inside = inside (I)
clay-stiff = stiff
clay-throwing = throwing
clay-soft = soft
clay-slip = slip
wetness = wetness
sponge = Sponge (B)
sponge-hint = water over the clay: it gets a little wetter, for everybody at the wheel
dries = the clay dries
dries-hint = the clay of this wheel loses its water slowly, as in a warm room; without it only what is seen dries
clay-figures = yields at { $yield } kPa, E { $youngs } MPa, { $time } ms
force-on = Give force again (Enter)
force-off = No force at once (Enter)
touching = touching the clay; pushed in { $depth } mm
not-touching = not touching; pushed in { $depth } mm
feel-force = you feel the force in your hand
feel-hum = the pad hums with the force, and the drawn tool stays behind by it
feel-lag = the drawn tool stays behind by the force
feel-nobody = nobody holds this tool: it goes by itself
hear = hear the clay (M)
no-sound = no sound here
you = you
potter = potter { $number }
person-touching = { $name }, touching

## What the pot is shown as

finish = shown as
finish-clay = clay
finish-biscuit = biscuit fired
finish-celadon = celadon glaze
finish-tenmoku = tenmoku glaze
finish-tin-white = tin-white glaze
finish-cobalt = cobalt glaze

## Files

pot-file = pot file
undo = Undo
redo = Redo
new-pot = New pot
new-pot-hint = for everybody at the wheel; undo takes it back
new-pot-again = as it began
form-cylinder = cylinder
form-bowl = bowl
form-bottle = bottle
form-ball = ball
remaking = the clay is being made again …
no-undo = nothing of yours to undo: the wheel remembers the last ten minutes
no-redo = nothing of yours to redo: pressing on after an undo keeps to it
no-pot = the studio cannot put that pot on this wheel
save = Save
open = Open
open-hint = puts the pot of the file on the wheel for everybody; undo takes it back
export-as = Export as
open-last = The pot of last time
file-busy = one moment …
written = written: { $path }
opened = { $path } is put on the wheel
replace = { $path } is there already: ask once more to replace it
no-name = Give the file a name first.
not-written = the work on the file failed: try again, and look at the file before you rely on it
no-thread = the system has no room left for the file's work ({ $reason }): close other programs and try again

## Preferences

preferences = Preferences
language = language
theme-dark = dark
theme-light = light
theme-system = as the system
text-size = text, %
lesson-again = Show the lesson
not-kept = your preferences are not kept: { $reason }

## The line of figures

status = H: keys · { $connection } · { $device }, hand { $pace }, { $late } % late · { $pictures } pictures/s on { $adapter }
connection = round trip { $rtt } ms · { $quality }
no-connection = no connection
device-mouse = mouse
device-rate = { $device } at { $rate } Hz
hand-rests = rests
priority-real-time = real-time
priority-ordinary = ordinary priority
quality-excellent = excellent
quality-good = good
quality-fair = fair
quality-slow = slow

## Sentences that must be seen

not-heard = the studio does not hear this client any more
silence = nothing comes from the studio at the moment; what you press may not count
coming-back = the connection broke; coming back to your seat …
waiting = waiting for the teacher to let you in again
waits-at-door = waiting for the teacher to let you in
door-keys = Esc: leave
closed = the studio has closed or the lesson is over; what you see is how the pot was left
force-is-off = the force is off: Enter gives it back

## A teacher's hand

guidance = A teacher's hand
guide-point = point
guide-point-hint = the student sees your tool, and what you draw on the pot with it
guide-lead = lead
guide-lead-hint = the student's tool is drawn to yours, the less the better it follows
guide-share = share
guide-share-hint = the tool is pressed between both hands, so many percent of the way to yours
guide-noise = disturb
guide-noise-hint = small pushes without order: what is practised against them is kept longer
guide-repel = repel
guide-repel-hint = the student's tool is pushed away from yours
guide-nobody = choose a student
guide-strength = strength
guide = guide (N)
take-over = take over (J)
let-go = let go (J)
wipe = wipe
taken-over-by = { $name } has taken your tool over
guided-by = { $name } guides you: { $mode }, { $percent } %
guided-apart = { $apart } mm from the teacher's tool, shown { $late } ms late
guided-help = help
guided-force = the teacher feels { $force } N
record = record (U)
record-keep = keep it (U)
play = show it (Y)
play-halt = your hand (Y)
play-speed = speed
target = what the pot is to become
target-pot = as your pot is now
target-file = as the pot file of that name
target-none = nothing
target-figures = off by { $rms } mm RMS, { $most } mm at most at { $at } mm; { $higher } mm higher
ended-teacher = The teacher has let go.
ended-own = You have let go.
ended-student = The student has let go.
ended-gone = The other hand is gone.
ended-replaced = The teacher guides another hand now.
no-guidance-teacher = Only a teacher can guide a hand.
no-guidance-nobody = Nobody of that number works at a wheel.
no-guidance-student = There is no student at a wheel to guide.
no-guidance-hand = Who guides needs a place at a wheel.
no-guidance-unknown = The server does not know that; is it of another version?
no-order-teacher = Only a teacher can do that; join with the teacher's token.
no-order-wheel = There is no wheel { $wheel } here.
no-order-person = Nobody here has the number { $number }.
no-order-cannot = That person's program cannot take a place at a wheel.
no-order-long-ago = The wheel remembers { $seconds } s and no more.
no-order-nothing = There is nothing of yours to take back at that wheel.

## The keys

keys = Keys
key-force = no force at once; again: force
key-press = press the tool in
key-push = push deeper, let out
key-move = move the tool
key-view = turn the view
key-zoom = closer, farther
key-wheel = wheel faster, slower, stop
key-tool = next tool
key-size = larger, smaller sphere
key-side = work inside the pot, outside
key-turn = turn the tool about its upright
key-roll = roll it
key-lean = lean it; upright again
key-clay = drier clay; a sponge over it
key-middle = fit a device to your hand; done, go on
key-sound = hear the clay or not
key-views = view as at first, as a profile, from above
key-cut = cut the pot open, close it
key-finish = shown as clay, fired, glazed
key-take-over = take a student's tool over; let go, or be free of a teacher's hand
key-guide = guide as chosen, let go
key-record = record your hand, show it
key-undo = undo your last stroke, redo it
key-new = new pot for everybody, as it began
key-files = save the pot, open one, export it
key-panel = fold the panel, open it
key-help = these keys, leave
press-left = left button, finger
press-ctrl = Ctrl
press-right = right button, two fingers, ← →
press-wheel = mouse wheel, W S
press-zoom = Ctrl + wheel, page up, down
press-arrows = ↑ ↓, space
press-move = Shift + ← → ↑ ↓
press-roll = A D, Shift + wheel
press-lean = F G, Alt + wheel; X

## A device that is fitted to the hand

no-fitting = what is in your hand needs no fitting: that is for devices that give force
fitting-begin = Fit the device to your hand (C)
fitting = Fit the device to your hand
fitting-rest = 1 of 2: where your hand rests
fitting-rest-how = Hold the device where your hand rests well, and press C or the device's button. Until the end there is no force.
fitting-reach = 2 of 2: how far it goes
fitting-reach-how = Move your hand up and down, and to all sides, as far as it goes without effort. Then press C or the button.
fitting-done = Does it suit?
fitting-done-how = The tool is in your hand again. Try whether foot and rim are within reach, then keep it.
fitting-nowhere = The device does not say where it is: the step waits for it.
fitting-scale = times as far as your hand
fitting-foot = foot
fitting-rim = rim
fitting-go-on = Go on
fitting-keep = Keep it
fitting-leave = As it was before

## The lesson

lesson = First five minutes
lesson-step = { $step } of { $steps }: { $name }
lesson-skip = Skip
lesson-centre = Centre
lesson-centre-how = Set the wheel to about 200 rpm (“centre”, or the up key). Rest the tool on the wall with the left button for three seconds: the clay runs true.
lesson-open = Open
lesson-open-how = Press I: the tool goes inside. Hold the left button near the rim, and the mouth opens.
lesson-pull = Pull
lesson-pull-how = Slow the wheel to about 80 rpm (“pull”). Hold the left button and move slowly from the foot to the rim: the wall thins and rises.
lesson-shape = Shape
lesson-shape-how = Press where you want a waist, come from inside where you want a belly. T changes the tool, K cuts the pot open, L shows it glazed.
lesson-done = That is a pot. Ctrl + S saves it; Ctrl + E exports it for a printer.
lesson-close = Close

## A session that is replayed

replay-equal = { $snapshots } snapshots came out as they were recorded
replay-unlike = the clay of { $seconds } s came out otherwise than it was recorded
replay-keys = space: play or pause · left, right: { $seconds } s · Home: begin · R: view · Esc: leave
page-keys = click: one wheel closely · left, right: turn · Esc: leave
page-keys-more = click: one wheel closely · left, right: turn · page up, page down: other wheels · Esc: leave
close-keys = left, right, drag: turn · Esc: all wheels
close-keys-alone = left, right, drag: turn · Esc: leave
replay-pause = Pause
replay-play = Play

## Who looks on

wheel-number = wheel { $number }
all-wheels = All wheels (Esc)
tile-progress = off by { $rms } mm RMS, { $most } mm at most
waiting-for-wheels = waiting for the wheels …
work-here = Work at this wheel
taking-place = taking a place at the wheel …
look-on = Look on instead
looking-again = the connection broke; looking again …
## People and the lesson

nicknames = otter, heron, badger, finch, beaver, robin, hare, owl, fox, swan, lynx, crane, marten, thrush, seal, stork, hedgehog, magpie, squirrel, falcon, dormouse, plover, mole, wren, newt, starling, toad, cuckoo, salmon, swift, trout, lark, pike, jay, carp, raven, perch, dove, eel, grouse, bee, quail, moth, gull, cricket, tern, beetle, eagle, snail, kite, bat, swallow, elk, nuthatch, bison, woodpecker, wolf, kingfisher, bear, sparrow, ibex, warbler, stoat, siskin
class-lesson = The lesson
class-teacher = teaches
class-guest = looks on
class-waits = waits at the door
class-away = away
class-looks-on = looks on
class-wheel = wheel { $wheel }
class-all-wheels = all wheels
class-to-wheel = to wheel { $wheel }
class-admit = let in
class-refuse = send away
class-admit-all = Let all in
class-freeze = Freeze
class-thaw = Thaw
class-open = Open
class-close = Close
class-settings = As mine
class-settings-hint = speed and wetness as at this window's wheel
class-pot = Same pot
class-pot-of = as on wheel { $wheel }
class-back = Back
class-back-by = by { $seconds } s
class-take-back = Take that back
class-code = code { $code }
class-locked = locked
class-lobby = lobby
class-new-code = New code
class-end = End the lesson
class-end-surely = Send everybody home?
class-progress = wheel { $wheel }, { $names }: off by { $rms } mm RMS, { $most } mm at most
leaving-ends = Others are here: press Esc once more to close the studio for everybody.
class-held = at the moment nobody's press counts here: look on
