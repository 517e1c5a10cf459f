package vantage.spy;

import java.awt.event.ActionEvent;
import java.util.concurrent.Executor;
import java.util.function.Function;
import javax.swing.AbstractAction;
import javax.swing.Action;
import javax.swing.JDesktopPane;
import javax.swing.JFrame;
import javax.swing.SwingUtilities;
import lcm.spy.ChannelData;

/**
 * What the plugins share. lcm-spy looks for classes that name SpyPlugin among their own interfaces,
 * so each of them does, beside extending this.
 */
abstract class MessagePlugin {
  private final String name;
  private final long fingerprint;
  private final Function<Executor, MessageView> makeView;

  MessagePlugin(String name, long fingerprint, Function<Executor, MessageView> makeView) {
    this.name = name;
    this.fingerprint = fingerprint;
    this.makeView = makeView;
  }

  public boolean canHandle(long fingerprint) {
    return fingerprint == this.fingerprint;
  }

  /** lcm-spy asks once with nulls, for the name in its menu, and then with an empty window. */
  public Action getAction(JDesktopPane desktop, ChannelData channel) {
    return new OpenAction(desktop, channel);
  }

  @Override
  public String toString() {
    return name;
  }

  private final class OpenAction extends AbstractAction {
    private static final long serialVersionUID = 1;
    private final transient JDesktopPane desktop;
    private final transient ChannelData channel;

    OpenAction(JDesktopPane desktop, ChannelData channel) {
      super(name + "...");
      this.desktop = desktop;
      this.channel = channel;
    }

    @Override
    public void actionPerformed(ActionEvent event) {
      if (SwingUtilities.getWindowAncestor(desktop) instanceof JFrame frame) {
        new MessageWindow(frame, channel, name, makeView);
      }
    }
  }
}
