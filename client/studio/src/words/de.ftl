### Was das Fenster sagt, auf Deutsch.

## The panel

fold = einklappen (P)
unfold = Bedienung (P)
others-join = Andere kommen dazu mit
address = Adresse  { $address }
code = Code
copy-command = Befehl kopieren
copy-link = Link kopieren
qr-code = Code für eine Kamera
wheel-rpm = Scheibe, U/min
wheel-centre = zentrieren
wheel-open = öffnen
wheel-pull = ziehen
wheel-trim = abdrehen
sphere = Kugel
tool-rib = Drehschiene
tool-blade = Klinge
tool-knuckle = Knöchel
tool-loop = Schlinge
tool-numbered = Nr. { $number }
radius = Radius
angle-turn = drehen
angle-lean = neigen
angle-roll = rollen
side-outside = außen
side-inside = innen (I)
clay-stiff = steif
clay-throwing = zum Drehen
clay-soft = weich
clay-slip = Schlicker
wetness = Feuchte
sponge = Schwamm (B)
sponge-hint = Wasser über den Ton: Er wird für alle an der Scheibe ein wenig nasser
dries = Ton trocknet
dries-hint = Der Ton dieser Scheibe verliert langsam sein Wasser, wie in einem warmen Raum; sonst trocknet nur, was man sieht
clay-figures = fließt ab { $yield } kPa, E { $youngs } MPa, { $time } ms
force-on = Kraft wieder geben (Enter)
force-off = Sofort keine Kraft (Enter)
touching = berührt den Ton; { $depth } mm eingedrückt
not-touching = berührt nichts; { $depth } mm eingedrückt
feel-force = die Kraft ist in der Hand zu spüren
feel-hum = das Gamepad brummt mit der Kraft, und das gezeichnete Werkzeug bleibt um sie zurück
feel-lag = das gezeichnete Werkzeug bleibt um die Kraft zurück
feel-nobody = niemand hält dieses Werkzeug: es geht von selbst
hear = den Ton hören (M)
no-sound = hier gibt es keinen Klang
you = du
potter = Töpfer { $number }
person-touching = { $name }, am Ton

## What the pot is shown as

finish = gezeigt als
finish-clay = Ton
finish-biscuit = geschrüht
finish-celadon = Seladonglasur
finish-tenmoku = Tenmokuglasur
finish-tin-white = weiße Zinnglasur
finish-cobalt = Kobaltglasur

## Files

pot-file = Topfdatei
undo = Zurück
redo = Wieder vor
new-pot = Neuer Topf
new-pot-hint = für alle an der Scheibe; Zurück nimmt es zurück
new-pot-again = wie am Anfang
form-cylinder = Zylinder
form-bowl = Schale
form-bottle = Flasche
form-ball = Kugel
remaking = der Ton wird neu geformt …
no-undo = nichts Eigenes zurückzunehmen: die Scheibe merkt sich die letzten zehn Minuten
no-redo = nichts Eigenes zu wiederholen: wer nach dem Zurücknehmen weiterdrückt, bleibt dabei
no-pot = die Werkstatt kann diesen Topf nicht auf diese Scheibe stellen
save = Speichern
open = Öffnen
open-hint = stellt den Topf der Datei für alle auf die Scheibe; Zurück nimmt es zurück
export-as = Ausgeben als
open-last = Der Topf vom letzten Mal
file-busy = einen Augenblick …
written = geschrieben: { $path }
opened = { $path } kommt auf die Scheibe
replace = { $path } gibt es schon: noch einmal ersetzt sie
no-name = Gib der Datei erst einen Namen.
not-written = die Arbeit an der Datei ist gescheitert: Versuch es noch einmal, und sieh dir die Datei an, bevor du dich auf sie verlässt
no-thread = das System hat für die Arbeit an der Datei keinen Platz mehr ({ $reason }): Schließ andere Programme und versuch es noch einmal

## Preferences

preferences = Einstellungen
language = Sprache
theme-dark = dunkel
theme-light = hell
theme-system = wie das System
text-size = Schrift, %
lesson-again = Die Einführung zeigen
not-kept = die Einstellungen werden nicht behalten: { $reason }

## The line of figures

status = H: Tasten · { $connection } · { $device }, Hand { $pace }, { $late } % zu spät · { $pictures } Bilder/s auf { $adapter }
connection = hin und zurück { $rtt } ms · { $quality }
no-connection = keine Verbindung
device-mouse = Maus
device-rate = { $device } mit { $rate } Hz
hand-rests = ruht
priority-real-time = Echtzeit
priority-ordinary = gewöhnlicher Vorrang
quality-excellent = ausgezeichnet
quality-good = gut
quality-fair = mäßig
quality-slow = langsam

## Sentences that must be seen

not-heard = die Werkstatt hört dieses Programm nicht mehr
silence = gerade kommt nichts von der Werkstatt; was du jetzt drückst, zählt vielleicht nicht
coming-back = die Verbindung ist abgebrochen; es geht gleich weiter an deinem Platz …
waiting = die Lehrperson lässt dich gleich wieder herein
waits-at-door = warte, bis dich die Lehrperson hereinlässt
door-keys = Esc: gehen
closed = die Werkstatt ist geschlossen oder der Unterricht zu Ende; so, wie du ihn siehst, blieb der Topf stehen
force-is-off = die Kraft ist aus: Enter gibt sie zurück

## Die Hand der Lehrperson

guidance = Die Hand der Lehrperson
guide-point = zeigen
guide-point-hint = man sieht dein Werkzeug, und was du damit auf den Topf zeichnest
guide-lead = führen
guide-lead-hint = das andere Werkzeug wird zu deinem gezogen, je besser es folgt, desto weniger
guide-share = teilen
guide-share-hint = gedrückt wird zwischen beiden Händen, so viel Prozent des Wegs zu deiner
guide-noise = stören
guide-noise-hint = kleine Stöße ohne Ordnung: was gegen sie geübt wird, bleibt länger
guide-repel = abstoßen
guide-repel-hint = das andere Werkzeug wird von deinem weggedrückt
guide-nobody = wen führen?
guide-strength = Stärke
guide = führen (N)
take-over = übernehmen (J)
let-go = loslassen (J)
wipe = wischen
taken-over-by = { $name } hat dein Werkzeug übernommen
guided-by = { $name } führt dich: { $mode }, { $percent } %
guided-apart = { $apart } mm vom Werkzeug der Lehrperson, { $late } ms später gezeigt
guided-help = Hilfe
guided-force = die Lehrperson spürt { $force } N
record = aufnehmen (U)
record-keep = behalten (U)
play = vorführen (Y)
play-halt = deine Hand (Y)
play-speed = Tempo
target = was der Topf werden soll
target-pot = wie dein Topf jetzt
target-file = wie die genannte Topfdatei
target-none = nichts
target-figures = { $rms } mm RMS daneben, höchstens { $most } mm bei { $at } mm; { $higher } mm höher
ended-teacher = Die Lehrperson hat losgelassen.
ended-own = Du hast losgelassen.
ended-student = Die geführte Hand hat losgelassen.
ended-gone = Die andere Hand ist fort.
ended-replaced = Die Lehrperson führt jetzt eine andere Hand.
no-guidance-teacher = Nur eine Lehrperson kann eine Hand führen.
no-guidance-nobody = Niemand mit dieser Nummer arbeitet an einer Scheibe.
no-guidance-student = An keiner Scheibe ist jemand, der sich führen ließe.
no-guidance-hand = Wer führt, braucht einen Platz an einer Scheibe.
no-guidance-unknown = Der Server kennt das nicht; ist er von einer anderen Version?
no-order-teacher = Das kann nur eine Lehrperson; tritt mit ihrem Token bei.
no-order-wheel = Hier ist keine Scheibe { $wheel }.
no-order-person = Hier hat niemand die Nummer { $number }.
no-order-cannot = Das Programm dieser Person kann an keiner Scheibe arbeiten.
no-order-long-ago = Die Scheibe erinnert sich an { $seconds } s und nicht an mehr.
no-order-nothing = An dieser Scheibe ist nichts von dir zurückzunehmen.

## The keys

keys = Tasten
key-force = sofort keine Kraft; noch einmal: Kraft
key-press = das Werkzeug eindrücken
key-push = tiefer drücken, nachlassen
key-move = das Werkzeug bewegen
key-view = die Ansicht drehen
key-zoom = näher, weiter weg
key-wheel = Scheibe schneller, langsamer, halt
key-tool = nächstes Werkzeug
key-size = größere, kleinere Kugel
key-side = im Topf arbeiten, außen
key-turn = das Werkzeug um die Hochachse drehen
key-roll = rollen
key-lean = neigen; wieder aufrecht
key-clay = trockenerer Ton; mit dem Schwamm darüber
key-middle = Gerät an die Hand anpassen; fertig, weiter
key-sound = den Ton hören oder nicht
key-views = Ansicht wie am Anfang, als Profil, von oben
key-cut = den Topf aufschneiden, schließen
key-finish = als Ton, gebrannt, glasiert zeigen
key-take-over = ein Werkzeug übernehmen; loslassen, oder sich von der Hand lösen
key-guide = führen wie gewählt, loslassen
key-record = die eigene Hand aufnehmen, vorführen
key-undo = den letzten eigenen Strich zurücknehmen, wiederholen
key-new = neuer Topf für alle, wie am Anfang
key-files = den Topf speichern, einen öffnen, ausgeben
key-panel = Bedienung einklappen, öffnen
key-help = diese Tasten, verlassen
press-left = linke Taste, Finger
press-ctrl = Strg
press-right = rechte Taste, zwei Finger, ← →
press-wheel = Mausrad, W S
press-zoom = Strg + Mausrad, Bild auf, ab
press-arrows = ↑ ↓, Leertaste
press-move = Umschalt + ← → ↑ ↓
press-roll = A D, Umschalt + Rad
press-lean = F G, Alt + Rad; X

## A device that is fitted to the hand

no-fitting = was du in der Hand hast, braucht keine Anpassung: Die ist für Geräte, die Kraft geben
fitting-begin = Gerät an die Hand anpassen (C)
fitting = Das Gerät an die Hand anpassen
fitting-rest = 1 von 2: wo die Hand ruht
fitting-rest-how = Halte das Gerät da, wo deine Hand gut ruht, und drücke C oder die Taste am Gerät. Bis zum Ende gibt es keine Kraft.
fitting-reach = 2 von 2: wie weit sie reicht
fitting-reach-how = Bewege die Hand auf und ab und nach allen Seiten, so weit es ohne Mühe geht. Drücke dann C oder die Taste.
fitting-done = Passt es?
fitting-done-how = Das Werkzeug ist wieder in der Hand. Probiere, ob Fuß und Rand erreichbar sind, und behalte es dann.
fitting-nowhere = Das Gerät sagt nicht, wo es ist: der Schritt wartet darauf.
fitting-scale = mal so weit wie die Hand
fitting-foot = Fuß
fitting-rim = Rand
fitting-go-on = Weiter
fitting-keep = Behalten
fitting-leave = Wie vorher

## The lesson

lesson = Die ersten fünf Minuten
lesson-step = { $step } von { $steps }: { $name }
lesson-skip = Überspringen
lesson-centre = Zentrieren
lesson-centre-how = Stell die Scheibe auf etwa 200 U/min („zentrieren“ oder die Pfeiltaste nach oben). Leg das Werkzeug drei Sekunden lang mit der linken Taste an die Wand: Der Ton läuft rund.
lesson-open = Öffnen
lesson-open-how = Drück I: Das Werkzeug geht nach innen. Halt die linke Taste nahe am Rand, und die Öffnung weitet sich.
lesson-pull = Ziehen
lesson-pull-how = Brems die Scheibe auf etwa 80 U/min („ziehen“). Halt die linke Taste und geh langsam vom Fuß zum Rand: Die Wand wird dünner und steigt.
lesson-shape = Formen
lesson-shape-how = Drück, wo du eine Taille willst, komm von innen, wo du einen Bauch willst. T wechselt das Werkzeug, K schneidet den Topf auf, L zeigt ihn glasiert.
lesson-done = Das ist ein Topf. Strg + S speichert ihn; Strg + E gibt ihn für einen Drucker aus.
lesson-close = Schließen

## A session that is replayed

replay-equal = { $snapshots } Stände kamen heraus, wie sie aufgezeichnet sind
replay-unlike = der Ton bei { $seconds } s kam anders heraus, als er aufgezeichnet ist
replay-keys = Leertaste: abspielen, anhalten · links, rechts: { $seconds } s · Pos1: Anfang · R: Ansicht · Esc: gehen
page-keys = Klick: eine Scheibe von nahem · links, rechts: drehen · Esc: gehen
page-keys-more = Klick: eine Scheibe von nahem · links, rechts: drehen · Bild auf, Bild ab: andere Scheiben · Esc: gehen
close-keys = links, rechts, ziehen: drehen · Esc: alle Scheiben
close-keys-alone = links, rechts, ziehen: drehen · Esc: gehen
replay-pause = Anhalten
replay-play = Abspielen

## Wer zuschaut

wheel-number = Scheibe { $number }
all-wheels = Alle Scheiben (Esc)
tile-progress = { $rms } mm RMS daneben, höchstens { $most } mm
waiting-for-wheels = warte auf die Scheiben …
work-here = An dieser Scheibe arbeiten
taking-place = ein Platz an der Scheibe wird eingenommen …
look-on = Stattdessen zuschauen
looking-again = die Verbindung ist abgebrochen; gleich ist wieder etwas zu sehen …
## Leute und Unterricht

nicknames = Otter, Reiher, Dachs, Fink, Biber, Rotkehlchen, Hase, Eule, Fuchs, Schwan, Luchs, Kranich, Marder, Drossel, Robbe, Storch, Igel, Elster, Eichhörnchen, Falke, Haselmaus, Regenpfeifer, Maulwurf, Zaunkönig, Molch, Star, Kröte, Kuckuck, Lachs, Segler, Forelle, Lerche, Hecht, Häher, Karpfen, Rabe, Barsch, Taube, Aal, Birkhuhn, Biene, Wachtel, Motte, Möwe, Grille, Seeschwalbe, Käfer, Adler, Schnecke, Milan, Fledermaus, Schwalbe, Elch, Kleiber, Wisent, Specht, Wolf, Eisvogel, Bär, Spatz, Steinbock, Grasmücke, Hermelin, Zeisig
class-lesson = Der Unterricht
class-teacher = unterrichtet
class-guest = schaut zu
class-waits = wartet an der Tür
class-away = nicht da
class-looks-on = schaut zu
class-wheel = Scheibe { $wheel }
class-all-wheels = alle Scheiben
class-to-wheel = an Scheibe { $wheel }
class-admit = einlassen
class-refuse = abweisen
class-admit-all = Alle einlassen
class-freeze = Anhalten
class-thaw = Weiter
class-open = Öffnen
class-close = Schließen
class-settings = Wie meine
class-settings-hint = Drehzahl und Feuchte wie an der Scheibe dieses Fensters
class-pot = Gleicher Topf
class-pot-of = wie auf Scheibe { $wheel }
class-back = Zurück
class-back-by = um { $seconds } s
class-take-back = Das zurücknehmen
class-code = Code { $code }
class-locked = abgeschlossen
class-lobby = Warteraum
class-new-code = Neuer Code
class-end = Unterricht beenden
class-end-surely = Alle nach Hause schicken?
class-progress = Scheibe { $wheel }, { $names }: { $rms } mm RMS daneben, höchstens { $most } mm
leaving-ends = Es sind noch andere hier: noch einmal Esc schließt die Werkstatt für alle.
class-held = im Moment zählt hier kein Druck: schau zu
