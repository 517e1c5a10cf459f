package vantage.spy;

import java.util.List;
import java.util.function.BiFunction;
import java.util.function.ToLongFunction;
import javax.swing.JComponent;

/** The last message of a channel as tables. */
final class ListView<M> implements MessageView {
  private final Class<M> type;
  private final ToLongFunction<M> seqOf;
  private final BiFunction<M, Long, List<Rows>> rowsOf;
  private final TablesPanel tables;
  private M latest; // Swing thread's.

  /** @param rowsOf makes tables of a message and the time now, us since the epoch */
  ListView(
      Class<M> type,
      ToLongFunction<M> seqOf,
      BiFunction<M, Long, List<Rows>> rowsOf,
      TablesPanel tables) {
    this.type = type;
    this.seqOf = seqOf;
    this.rowsOf = rowsOf;
    this.tables = tables;
  }

  @Override
  public JComponent component() {
    return tables.component();
  }

  @Override
  public long seq(Object message) {
    return seqOf.applyAsLong(type.cast(message));
  }

  @Override
  public Runnable prepare(Object message) {
    M shown = type.cast(message);
    List<Rows> rows = rowsOf.apply(shown, 1000 * System.currentTimeMillis());
    return () -> {
      latest = shown;
      tables.show(rows);
    };
  }

  @Override
  public void refresh(long nowUtime) {
    if (latest != null) {
      tables.show(rowsOf.apply(latest, nowUtime));
    }
  }
}
